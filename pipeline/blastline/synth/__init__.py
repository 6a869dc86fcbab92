"""Physical gunshots, film beds and scenes, with exact truth: for fixtures, demonstrations, training and studies."""

from .apart import stands_out_db
from .beds import BED_KINDS, BedKind, random_bed
from .colour import draw_colour, record
from .designed import designed_negative, designed_shot
from .echoes import with_acoustics
from .files import render_scene, synthesise, truth_of, write_scene
from .film import film_scene
from .handling import handling
from .jets import jet_shot
from .mix import SceneAudio
from .negatives import NEGATIVE_KINDS, NegativeKind, random_negative
from .outdoors import outdoor_shot
from .plain import plain_negative
from .plain_beds import plain_bed
from .plain_shots import plain_shot
from .rooms import ENVIRONMENTS, draw_acoustics
from .scene import Scene, load_scene
from .shots import random_shot
from .steps import soft_step
from .truth import NegativeTruth, ShotTruth, Truth, decode_truth, encode_truth

__all__ = [
    "BED_KINDS",
    "ENVIRONMENTS",
    "NEGATIVE_KINDS",
    "BedKind",
    "NegativeKind",
    "NegativeTruth",
    "Scene",
    "SceneAudio",
    "ShotTruth",
    "Truth",
    "decode_truth",
    "designed_negative",
    "designed_shot",
    "draw_acoustics",
    "draw_colour",
    "encode_truth",
    "film_scene",
    "handling",
    "jet_shot",
    "load_scene",
    "outdoor_shot",
    "plain_bed",
    "plain_negative",
    "plain_shot",
    "random_bed",
    "random_negative",
    "random_shot",
    "record",
    "render_scene",
    "soft_step",
    "stands_out_db",
    "synthesise",
    "truth_of",
    "with_acoustics",
    "write_scene",
]
