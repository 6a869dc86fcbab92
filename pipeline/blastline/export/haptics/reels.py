"""Where a long film is cut into reels: at whole seconds, where nothing vibrates."""

from .track import HapticTrack

LONGEST_BACK_S = 60
"""How far before its place a cut may be put to spare a segment; one that lasts longer is cut."""


def reel_edges(track: HapticTrack) -> list[int]:
    """Return the first frame of each reel and, last, where the film's vibration and the film have ended.

    A cut stands at each multiple of the reels' length, or at the last whole second before a segment that goes on there.
    Each cut depends on what is near it alone, so an edit elsewhere moves none. A reel lasts at most a minute more.
    """
    rate_hz = track.rate_hz
    end = max([track.frames, *(segment.span.stop for segment in track.segments)])
    edges = [0]
    place_s = round(track.reel_s)
    while place_s * rate_hz < end:
        cut_s = place_s
        for segment in track.segments:
            if segment.span.start < place_s * rate_hz < segment.span.stop:
                before_s = segment.span.start // rate_hz
                cut_s = before_s if before_s >= place_s - LONGEST_BACK_S else place_s
        if cut_s * rate_hz > edges[-1]:
            edges.append(cut_s * rate_hz)
        place_s += round(track.reel_s)
    return [*edges, end]
