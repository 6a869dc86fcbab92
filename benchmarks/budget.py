"""How well `--budget` predicts: `python benchmarks/budget.py [--minutes 120]`.

Synthesises a busy action film of 10 minutes, a quiet drama of 20, and a film of 10 with 5.1 sound as AC-3 in Matroska
(kept in build/bench), and prints for each tier what was predicted for its rendering, with report, and what it took, in
CPU seconds without start-up. The last column is what the predicting took. Then it runs the command for each track with
a budget that fits, and compares the whole process with what it was told. `--minutes` adds a film of that
length with 2.5 shots a minute.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
from pathlib import Path

from film import BENCH, encoded, made, made_of, measured

START_S = 4.0
QUALITIES = ("draft", "standard", "reference")
GAUGE = """
import tempfile, time
from dataclasses import replace
from pathlib import Path
from blastline import run
from blastline.run.gauge import open_gauge

film, options = Path(FILM), run.RenderOptions(overwrite=True)
figures = {}
with tempfile.TemporaryDirectory() as folder:
    run.render(Path(SHORT), Path(folder) / "warm", options)
    began = time.process_time()
    with open_gauge(film, options, drives=True) as gauge:
        for quality in QUALITIES:
            figures[quality + "_predicted"] = gauge.cost(quality).of(gauge.film_s)
    figures["gauging"] = time.process_time() - began
    for quality in QUALITIES:
        began = time.process_time()
        run.render(film, Path(folder) / quality, replace(options, quality=quality))
        figures[quality] = time.process_time() - began
print(json.dumps(figures))
"""


def scene(minutes: float, *, shots: int, negatives: int, beds: list[tuple[str, float]], layout: str = "mono") -> str:
    lines = ["schema = 1", "rate_hz = 48000", f"duration_s = {minutes * 60.0}", "seed = 77", f'layout = "{layout}"']
    for kind, level in beds:
        lines += ["[[beds]]", f'kind = "{kind}"', f"level_dbfs = {level}"]
    return "\n".join(
        [*lines, "[random]", f"shots = {shots}", f"negatives = {negatives}", "shot_snr_db = [8.0, 40.0]", ""]
    )


def tracks() -> dict[str, Path]:
    loud = [("music", -27.0), ("dialogue", -28.0), ("engine", -34.0), ("crowd", -38.0)]
    action = scene(10, shots=120, negatives=100, beds=loud)
    drama = scene(20, shots=8, negatives=40, beds=[("dialogue", -32.0), ("ambience", -50.0)])
    surround = scene(10, shots=40, negatives=60, beds=loud[:2], layout="5.1")
    film = made_of("surround-film", surround)
    coded = film.with_suffix(".mkv")
    if not coded.is_file() or coded.stat().st_mtime < film.stat().st_mtime:
        encoded(film)
    return {"action, 10 min": made_of("action", action), "drama, 20 min": made_of("drama", drama), "5.1 AC-3": coded}


def gauged(name: str, film: Path, short: Path) -> float:
    """Print a row for each tier; return a budget that fits, twice what standard takes: a new process costs more."""
    code = GAUGE.replace("FILM", repr(str(film))).replace("SHORT", repr(str(short)))
    found = measured(code.replace("QUALITIES", repr(QUALITIES)))
    for quality in QUALITIES:
        predicted, took = found[f"{quality}_predicted"], found[quality]
        share = f"{100.0 * found['gauging'] / took:.0f} %"
        print(
            f"| {name} | {quality} | {predicted:.2f} | {took:.2f} | {predicted / took - 1.0:+.0%} | {share} |",
            flush=True,
        )
    return 2.0 * (START_S + found["gauging"] + found["standard_predicted"])


def told(name: str, film: Path, budget_s: float) -> None:
    """Run the command with a budget and print what it said and what the process took."""
    out = BENCH / "budget-out"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    options = ["--budget", f"{budget_s:.2f}s", "--overwrite", "-q"]
    command = [sys.executable, "-m", "blastline", "render", str(film), "-o", str(out), *options]
    ended = subprocess.run(command, check=False, capture_output=True, text=True, env=os.environ)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    took = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if ended.returncode == 2:
        print(f"{name}: {ended.stderr.strip()}")
        return
    timeline = json.loads((out / "timeline.json").read_text(encoding="utf-8"))
    predicted = timeline["budget"]["predicted_cpu_s"][timeline["quality"]]
    print(
        f"{name}: {timeline['budget']['note']}; took {took:.2f} s, predicted {predicted / took - 1.0:+.0%}", flush=True
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float)
    options = parser.parse_args()
    films, short = tracks(), made("film1", 1)
    if options.minutes:
        films[f"{options.minutes:g} min"] = made(f"film{options.minutes:g}", options.minutes)
    print("| track | quality | predicted, CPU s | took | off by | gauging all, of it |")
    print("| --- | --- | --- | --- | --- | --- |")
    needed = {name: gauged(name, film, short) for name, film in films.items()}
    for name, film in films.items():
        told(name, film, needed[name])


if __name__ == "__main__":
    main()
