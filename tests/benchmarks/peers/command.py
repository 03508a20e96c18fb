"""The command line."""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import time
from pathlib import Path

from . import measuring, page, results, sources
from .measuring import Programs, write
from .worker import Worker, WorkerError, serve

ROOT = Path(__file__).resolve().parents[3]
SCRIPT = ROOT / "tests" / "benchmarks" / "peers.py"
WORKERS = ("source", "ours", "cycles", "eevee", "mitsuba")


def main(words: list[str]) -> int:
    if words[:1] == ["--worker"]:
        return _worker(*words[1:])
    options = _options(words)
    known = sources.names(options.meshes)
    wanted = options.scenes.split(",") if options.scenes else list(known)
    unknown = [name for name in wanted if name not in known]
    if unknown:
        print(f"there is no scene called {unknown[0]}; there are {', '.join(known)}", file=sys.stderr)
        return 2
    sweep = "quick" if options.quick else "full"
    settings = {"sweep": sweep, "size": list(options.size), "reference_error": options.reference_error}
    options.out.mkdir(parents=True, exist_ok=True)
    if not _same_settings(options.out / "settings.json", settings):
        print(f"{options.out} holds a run with other settings; name another folder", file=sys.stderr)
        return 2
    programs = Programs(SCRIPT, options.embree or find_embree_loop())
    failed = 0
    for name in wanted:
        folder = options.out / name
        started = time.monotonic()
        print(name, flush=True)
        try:
            _prepare(programs, name, known[name], options.size, folder)
            measuring.Round(folder, programs, sweep, options.reference_error).run()
        except WorkerError as error:
            failed += 1
            print(f"  {error}", file=sys.stderr)
        print(f"  {time.monotonic() - started:.0f} s", flush=True)
    report = results.collect(options.out, wanted, settings, " ".join(["python tests/benchmarks/peers.py", *words]))
    write(options.out / "peers.json", report)
    page.draw(report, options.out / "peers.svg")
    page.draw(report, options.out / "peers.png")
    (options.out / "peers.md").write_text(page.section(report), encoding="utf-8")
    print(page.section(report))
    if options.write:
        page.put_into_docs(report, ROOT / "docs")
    return 1 if failed else 0


def _options(words: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="peers.py", description="Ours beside Cycles, EEVEE, Mitsuba and bare Embree")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="measured points, results, plots")
    parser.add_argument("--quick", action="store_true", help="fewer settings and runs: about ten minutes for the four")
    parser.add_argument("--scenes", help=f"of {sources.KNOT}, {', '.join(sources.EXAMPLES)} and the meshes")
    parser.add_argument("--meshes", type=Path, metavar="DIR", help="a folder of meshes; each gets a floor and a light")
    parser.add_argument("--size", default="512x512", type=lambda text: tuple(int(n) for n in text.split("x")))
    parser.add_argument("--reference-error", type=float, default=0.002, metavar="X", help="standard error of truth")
    parser.add_argument("--embree", type=Path, metavar="PROGRAM", help="penumbra_embree_loop; looked for in build/")
    parser.add_argument("--write", action="store_true", help="put the outcome into docs/performance.md")
    return parser.parse_args(words)


def find_embree_loop() -> Path | None:
    """The newest one built in this checkout, or one on the path."""
    built = [file for file in (ROOT / "build").rglob("penumbra_embree_loop") if os.access(file, os.X_OK)]
    if built:
        return max(built, key=lambda file: file.stat().st_mtime)
    found = shutil.which("penumbra_embree_loop")
    return Path(found) if found else None


def _same_settings(file: Path, settings: dict[str, object]) -> bool:
    import json

    if file.is_file():
        return bool(json.loads(file.read_text(encoding="utf-8")) == settings)
    write(file, settings)
    return True


def _prepare(programs: Programs, name: str, file: Path | None, size: tuple[int, int], folder: Path) -> None:
    """In a process of its own, because Blender as a module is not left without a trace."""
    from .exchange import SCENE_FILE

    if (folder / SCENE_FILE).is_file():
        return
    folder.mkdir(parents=True, exist_ok=True)
    arguments = [name, str(file or ""), f"{size[0]}x{size[1]}"]
    Worker([*programs.command("source", folder), *arguments], folder / "source.log").close()


def _worker(name: str, folder: str, *rest: str) -> int:
    """This script again, as one of its workers."""
    from .worker import Peer

    path = Path(folder)

    def make() -> Peer:
        if name == "source":
            scene, file, size = rest
            width, height = (int(n) for n in size.split("x"))
            return sources.Made(scene, Path(file) if file else None, (width, height), path)
        if name == "ours":
            from .ours import Ours

            return Ours(path)
        if name == "mitsuba":
            from .mitsuba import Mitsuba

            return Mitsuba(path)
        from .blender import Cycles, Eevee

        return Cycles(path) if name == "cycles" else Eevee(path)

    return serve(make)
