"""What a whole film costs: `python benchmarks/film.py [--minutes 120] [--quality draft ...] [--report | --detect]`.

Synthesises a mono 16-bit film with 2.5 shots a minute (kept in build/bench), reads it with soundfile in float32 blocks,
then runs `render`, or `detect`, and prints the CPU time of both, their ratio and the peak memory. They run in processes
of their own; start-up and imports are not counted. `--ac3` makes 5.1 sound of it, as WAV and as AC-3 in a film
container, and compares the onsets found in the two. `--sides` compares what it costs to listen to the two
once, and once more without the centre.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path
from typing import get_args

from blastline.model import Quality

BENCH = Path("build/bench")
SYNTH = Path(__file__).parents[1] / "pipeline" / "blastline" / "synth"
READ = """
import time, soundfile
def read(path):
    with soundfile.SoundFile(path) as file:
        for block in file.blocks(65536, dtype="float32"):
            pass
"""
RENDER = """
import time
from pathlib import Path
from blastline import run
def render(path, report):
    out = Path(path).parent / "out"
    options = run.RenderOptions(quality=QUALITY, report=report, overwrite=True)
    return run.render(Path(path), out, options)
"""
DETECT = """
import time
from pathlib import Path
from blastline import run
def detect(path, rules=None):
    return run.detect(Path(path), run.RenderOptions(quality=QUALITY, rules=rules and Path(rules)))
"""
MEASURE = """
import json
def peak_mb():
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) / 1024 for line in status if line.startswith("VmHWM"))
"""


def scene(minutes: float, layout: str) -> str:
    """Return a film-like scene: changing beds, shots and hard negatives."""
    beds = [("dialogue", -30.0, 0.0, 1.0), ("ambience", -48.0, 0.0, 1.0), ("engine", -38.0, 0.3, 0.5)]
    lines = ["schema = 1", "rate_hz = 48000", f"duration_s = {minutes * 60.0}", "seed = 42", f'layout = "{layout}"']
    for kind, level, start, stop in beds:
        lines += ["[[beds]]", f'kind = "{kind}"', f"level_dbfs = {level}"]
        lines += [f"start_s = {start * minutes * 60.0}", f"stop_s = {stop * minutes * 60.0}"]
    shots = round(2.5 * minutes)
    return "\n".join(
        [*lines, "[random]", f"shots = {shots}", f"negatives = {2 * shots}", "shot_snr_db = [12.0, 40.0]", ""]
    )


def made(name: str, minutes: float, layout: str = "mono") -> Path:
    """Return the film, synthesised unless it is there already and no older than what makes it."""
    return made_of(name, scene(minutes, layout))


def made_of(name: str, text: str) -> Path:
    """Return the film of a scene, synthesised unless it is there already and no older than what makes it."""
    path = BENCH / name / f"{name}.wav"
    changed = max(source.stat().st_mtime for source in SYNTH.glob("*.py"))
    if not path.is_file() or path.stat().st_mtime < changed:
        BENCH.mkdir(parents=True, exist_ok=True)
        (BENCH / f"{name}.toml").write_text(text, encoding="utf-8")
        arguments = ["synth", str(BENCH / f"{name}.toml"), "-o", str(path.parent), "--overwrite"]
        subprocess.run([sys.executable, "-m", "blastline", *arguments], check=True)
    return path


def measured(code: str) -> dict[str, float]:
    """Run code in a process of its own, one BLAS thread, and return what it prints as JSON."""
    command = ["env", "OPENBLAS_NUM_THREADS=1", sys.executable, "-c", MEASURE + code]
    printed = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    figures: dict[str, float] = json.loads(printed.splitlines()[-1])
    return figures


def timed(setup: str, call: str, warm: str) -> dict[str, float]:
    """Return CPU seconds and peak memory of a call after a warm-up on a short film, which imports everything."""
    clock = f"started = time.process_time(); {call}; spent = time.process_time() - started"
    return measured(f'{setup}\n{warm}\n{clock}\nprint(json.dumps({{"cpu_s": spent, "peak_mb": peak_mb()}}))')


def compare(minutes: float, *, quality: Quality, setup: str, call: str) -> None:
    """Print one row of the table: `call`, of a film's path, is made after `setup`."""
    film, short = made(f"film{minutes:g}", minutes), made("film1", 1)
    read = timed(READ, f"read({str(film)!r})", f"read({str(short)!r})")
    done = timed(setup.replace("QUALITY", repr(quality)), call.format(str(film)), call.format(str(short)))
    print(
        f"| {minutes:g} | {quality} | {read['cpu_s']:.2f} | {done['cpu_s']:.2f} | {done['cpu_s'] / read['cpu_s']:.1f} "
        f"| {done['peak_mb']:.0f} |",
        flush=True,
    )


def encoded(wav: Path) -> Path:
    """Return the film as AC-3 5.1 in Matroska."""
    import soundfile

    from blastline.study.codecs import encode

    path = wav.with_suffix(".mkv")
    samples, rate_hz = soundfile.read(wav, dtype="float32", always_2d=True)
    encode(path, samples, "ac3", bits_per_s=448_000, rate_hz=rate_hz)
    return path


def compare_codecs(minutes: float, quality: Quality) -> None:
    """Print how far the onsets found in an AC-3 film are from those found in the sound it was made of."""
    from blastline import run

    wav = made(f"surround{minutes:g}", minutes, "5.1")
    plain = run.detect(wav, run.RenderOptions(quality=quality))
    coded = run.detect(encoded(wav), run.RenderOptions(quality=quality))
    there = [event.onset_s * 1000.0 for event in plain.events]
    errors = [min((abs(event.onset_s * 1000.0 - at) for at in there), default=1e9) for event in coded.events]
    near = [error for error in errors if error <= 10.0]
    print(f"WAV: {len(there)} shots; AC-3: {len(errors)}, {len(near)} of them in both")
    print(f"onsets apart: largest {max(near, default=0.0):.3f} ms; within 1 ms: {sum(e <= 1.0 for e in near)}")


def compare_listenings(minutes: float, quality: Quality) -> None:
    """Print what finding the shots of a 5.1 film costs, heard once and twice."""
    print("| sound | heard | detect, CPU s | peak MB |")
    print("| --- | --- | --- | --- |")
    setup = DETECT.replace("QUALITY", repr(quality))
    wav, short = made(f"surround{minutes:g}", minutes, "5.1"), made("film1", 1)
    for path in (wav, encoded(wav)):
        for heard, sides in (("once", "false"), ("twice", "true")):
            rules = BENCH / heard / "quality"
            rules.mkdir(parents=True, exist_ok=True)
            (rules / f"{quality}.toml").write_text(f"[channels]\nsides = {sides}\n", encoding="utf-8")
            calls = [f"detect({str(each)!r}, {str(rules.parent)!r})" for each in (path, short)]
            spent = timed(setup, calls[0], calls[1])
            print(f"| {path.suffix[1:]} | {heard} | {spent['cpu_s']:.2f} | {spent['peak_mb']:.0f} |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, nargs="+", default=[10.0, 120.0])
    parser.add_argument("--quality", nargs="+", default=["standard"], choices=get_args(Quality))
    parser.add_argument("--report", action="store_true")
    parser.add_argument("--detect", action="store_true")
    parser.add_argument("--ac3", action="store_true")
    parser.add_argument("--sides", action="store_true")
    options = parser.parse_args()
    if options.sides:
        compare_listenings(options.minutes[0], options.quality[0])
        return
    if options.ac3:
        compare_codecs(options.minutes[0], options.quality[0])
        return
    setup, call = (DETECT, "detect({!r})") if options.detect else (RENDER, f"render({{!r}}, {options.report})")
    print(f"| minutes | quality | soundfile read, CPU s | {call.partition('(')[0]}, CPU s | ratio | peak MB |")
    print("| --- | --- | --- | --- | --- | --- |")
    for minutes in options.minutes:
        for quality in options.quality:
            compare(minutes, quality=quality, setup=setup, call=call)


if __name__ == "__main__":
    main()
