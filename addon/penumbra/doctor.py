"""`penumbra doctor`: what works on this machine, and what to install where something does not."""

from __future__ import annotations

import importlib.util
from dataclasses import asdict, dataclass, field
from typing import Any

from . import cache, environment, native
from .errors import UserError, sentence_of
from .files import why_not_writable

_REPORT_LIBRARIES = {
    "jinja2": "jinja2",
    "matplotlib": "matplotlib",
    "PIL": "pillow",
    "flip_evaluator": "flip-evaluator",
    "rich": "rich",
}


@dataclass(slots=True)
class Check:
    name: str
    works: bool
    found: str = ""  # what is there
    cure: str = ""  # what to do if it does not work
    needed: bool = True  # for `penumbra compare`
    details: list[str] = field(default_factory=list)


def examine(device: str, view_by: str = "") -> list[Check]:
    """All checks; never raises for what it finds."""
    core, core_check = _core()
    checks = [core_check]
    if core is not None:
        checks += [_devices(core), _context(core, device), _view(view_by), _embree(core)]
    return [*checks, _blender(), _report(), _cache()]


def healthy(checks: list[Check]) -> bool:
    """True if `penumbra compare` would work."""
    return all(check.works for check in checks if check.needed)


def to_json(checks: list[Check]) -> dict[str, Any]:
    return {"healthy": healthy(checks), "checks": [asdict(check) for check in checks]}


def text(checks: list[Check]) -> str:
    lines = []
    for check in checks:
        state = "ok      " if check.works else ("MISSING " if check.needed else "no      ")
        lines.append(f"{state}{check.name}: {check.found}".rstrip(": "))
        lines += [f"          {detail}" for detail in check.details]
        if not check.works and check.cure:
            lines.append(f"          to do: {check.cure}")
    lines += ["", "Ready." if healthy(checks) else "Not ready: do what is missing above."]
    return "\n".join(lines)


def _core() -> tuple[Any, Check]:
    try:
        core = native.load()
    except UserError as error:
        return None, Check("core", False, str(error), "pip install penumbra")
    return core, Check("core", True, f"penumbra_core {core.__version__}")


def _devices(core: Any) -> Check:
    cure = "install a graphics driver, or the software one: apt install libegl1 libgl1-mesa-dri"
    try:
        devices = list(core.devices())
    except Exception as error:
        return Check("EGL devices", False, sentence_of(error), cure)
    if not devices:
        return Check("EGL devices", False, str(core.device_problem()) or "none", cure)
    usable = [device for device in devices if device["usable"]]
    details = [
        f"{device['index']}: {device['name']}, {device['gl_version']}{' (software)' if device['software'] else ''}"
        if device["usable"]
        else f"{device['index']}: {device['name'] or 'unnamed'}, not usable: {device['reason']}"
        for device in devices
    ]
    return Check("EGL devices", bool(usable), f"{len(usable)} of {len(devices)} usable", cure, details=details)


def _context(core: Any, device: str) -> Check:
    try:
        facts = dict(native.renderer(core, device, "raster").environment)
    except Exception as error:
        return Check("OpenGL", False, sentence_of(error), "apt install libegl1 libgl1-mesa-dri, or set PENUMBRA_DEVICE")
    return Check("OpenGL", True, f"{facts['gl_renderer']}, {facts['gl_version']}, {facts['threads']} threads")


def _view(asked: str) -> Check:
    try:
        view_by = native.view_by(asked)
    except UserError as error:
        return Check("view", False, str(error), "correct or unset PENUMBRA_VIEW_BY")
    return Check("view", True, {"raster": "drawn by OpenGL", "rays": "traced by Embree"}[view_by] + f" ({view_by})")


def _embree(core: Any) -> Check:
    try:
        return Check("Embree", True, str(core.embree_version()))
    except Exception as error:
        cure = "apt install libembree3-3 (bookworm) or libembree4-4 (trixie)"
        return Check("Embree", False, sentence_of(error), cure)


def _blender() -> Check:
    from . import scenes

    try:
        scenes.import_bpy()
    except scenes.SceneError as error:
        return Check("Blender", False, str(error), "pip install 'penumbra[bpy]'")
    return Check("Blender", True, environment.blender_version())


def missing_libraries() -> list[str]:
    """Packages that a report needs and that are not installed. Looks, but loads none."""
    return [package for module, package in _REPORT_LIBRARIES.items() if importlib.util.find_spec(module) is None]


def _report() -> Check:
    missing = missing_libraries()
    found = f"missing: {', '.join(missing)}" if missing else "all libraries present"
    return Check("report", not missing, found, f"pip install {' '.join(missing)}")


def _cache() -> Check:
    try:
        kept = cache.ReferenceCache.of_user()
    except UserError as error:
        return Check("cache", False, str(error), "correct or unset PENUMBRA_CACHE_SIZE", needed=False)
    reason = why_not_writable(kept.root)
    size = f"{kept.entries()} references, {kept.size_bytes() / 2**20:.0f} of {kept.max_bytes / 2**20:.0f} MiB"
    cure = f"make {kept.root} writable or set PENUMBRA_CACHE"
    return Check("cache", not reason, f"{kept.root}, {reason or size}", cure, needed=False)
