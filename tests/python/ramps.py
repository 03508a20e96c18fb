"""A comparison made from closed forms: linear penumbra ramps under a strip light, and well-known wrong answers to them.

No stand-in for the core: every array is computed here, and its errors too, with numpy alone.
"""

from __future__ import annotations

import numpy as np
from penumbra import precision, together, verdict
from penumbra.compare import reference_info
from penumbra.records import Comparison, LightResult, Record, ReferenceResult, SceneResult, Spread, Statistic, Step
from penumbra.sweep import entry as sweep_entry

CLEAR = 1e-4  # the penumbra is where the truth lies between this and one minus this


def errors_of(visibility: np.ndarray, truth: np.ndarray, noise: np.ndarray, mask: np.ndarray) -> dict:
    """The figures of core.measure_errors for one deterministic image (docs/measuring.md)."""
    inside = mask != 0
    e, t = (visibility - truth)[inside].astype(np.float64), truth[inside]
    umbra, lit = t <= CLEAR, t >= 1 - CLEAR
    penumbra = ~umbra & ~lit
    magnitude = np.abs(e)
    bins = np.clip((t * 32).astype(int), 0, 31)
    profile = np.zeros_like(e)
    for b in range(32):
        chosen = penumbra & (bins == b)
        if chosen.any():
            profile[chosen] = e[chosen].mean()
    n = max(e.size, 1)
    parts = {
        "noise": 0.0,
        "leak": float((e[umbra] ** 2).sum() / n),
        "over_darkening": float((e[lit] ** 2).sum() / n),
        "bias": float((profile**2).sum() / n),
        "aliasing": float(((e - profile)[penumbra] ** 2).sum() / n),
    }
    rmse = float(np.sqrt((e**2).mean())) if e.size else 0.0
    own = float(np.sqrt((noise[inside].astype(np.float64) ** 2).mean())) if e.size else 0.0
    dominant = max(parts, key=lambda name: parts[name]) if rmse > 0 else "none"
    share = parts[dominant] / rmse**2 if rmse > 0 else 0.0
    return {
        "pixels": int(e.size),
        "penumbra_pixels": int(penumbra.sum()),
        "rmse": rmse,
        "mae": float(magnitude.mean()) if e.size else 0.0,
        "bias": float(e.mean()) if e.size else 0.0,
        "p95": float(np.percentile(magnitude, 95)) if e.size else 0.0,
        "p99": float(np.percentile(magnitude, 99)) if e.size else 0.0,
        "max": float(magnitude.max(initial=0.0)),
        "penumbra_rmse": float(np.sqrt((e[penumbra] ** 2).mean())) if penumbra.any() else 0.0,
        "leak": float(visibility[inside][umbra].mean()) if umbra.any() else 0.0,
        "over_darkening": float((1 - visibility[inside][lit]).mean()) if lit.any() else 0.0,
        "penumbra_width_ratio": 1.0,
        "reference_standard_error": own,
        "within_reference_noise": rmse <= own,
        "parts": parts,
        "dominant": dominant,
        "sentence": f"{dominant} makes {share:.0%} of the mean square error." if rmse > 0 else "No error at all.",
    }


def spread(median: float, width: float = 0.04, runs: int = 12, tight: bool | None = None) -> Spread:
    p10, p90 = median * (1 - 2 * width), median * (1 + 3 * width)
    return Spread(median, p10, p90, median * (1 - width), median * (1 + width), runs, tight)


def ramp_scene(width: int = 640, height: int = 360, lights: int = 2, seed: int = 1) -> SceneResult:
    """A wall's shadow that widens towards the top of the image, and a round pillar's on a tiled floor."""
    generator = np.random.default_rng(seed)
    y, x = np.mgrid[0:height, 0:width].astype(np.float32)
    x, y = x / width, y / height
    sky = y > 0.86
    tiles = ((np.floor(x * 12) + np.floor(y * 9)) % 2)[..., None]
    albedo = (0.55 + 0.2 * tiles) * np.array([1.0, 0.96, 0.9])
    ball = (x - 0.62) ** 2 + ((y - 0.45) * height / width) ** 2 < 0.006
    albedo[ball] = (0.75, 0.28, 0.2)
    albedo[sky] = 0
    scene = SceneResult(
        path="/scenes/ramps & <walls>.blend",
        camera="Camera",
        frame=1,
        size=(width, height),
        triangles=20480,
        summary={"triangles": 20480, "instances": 12, "lights": lights},
        notes=['The mesh "Fence" has no material: grey 0.8 is used.', "Light probes are left out."],
        albedo=albedo.astype(np.float32),
        hit=(~sky).astype(np.uint8),
    )
    for index in range(lights):
        centre = 0.35 + 0.2 * index
        half_width = (0.02 + 0.16 * y) * (1 + index)
        distance = (x - centre) / half_width
        truth = np.clip(0.5 + 0.5 * distance, 0, 1).astype(np.float32)
        irradiance_truth = (truth**1.15).astype(np.float32)
        mask = (~sky).astype(np.uint8)
        noise = np.where((truth > 0) & (truth < 1) & (mask > 0), np.float32(0.0018), np.float32(0)).astype(np.float32)
        power = (9.0 / (0.4 + (x - 0.7 + 0.5 * index) ** 2 + (y - 0.4) ** 2))[..., None] * np.array(
            [1.0, 0.93 - 0.1 * index, 0.84]
        )
        reference = ReferenceResult(
            "ray traced",
            truth,
            irradiance_truth,
            noise,
            noise,
            mask,
            88_123_456,
            441.2,
            0.002,
            5321.0,
            True,
            int(sky.sum()),
        )
        light = LightResult(
            name=("Key", "Fill.001", "Rim")[index % 3],
            shape=("rectangle", "ellipse", "sun")[index % 3],
            size_m=[1.2, 0.8],
            summary={"lit_pixels": int(mask.sum()), "casters": 9, "casters_left_out": 3},
            reference=reference,
            reference_info=reference_info(reference),
            irradiance=np.where(sky[..., None], 0, power).astype(np.float32),
        )
        stairs = np.floor(distance * half_width * 60) / 60 / half_width
        candidates = [
            (
                "shadow_map",
                "Hard shadow map",
                {"resolution": 1024, "bias": 0.01},
                (stairs > 0).astype(np.float32),
                6.1,
                None,
            ),
            (
                "pcf",
                "Percentage closer filtering",
                {"kernel": 9, "resolution": 1024},
                np.clip(0.5 + distance / 1.1, 0, 1),
                9.4,
                None,
            ),
            (
                "pcf",
                "Percentage closer filtering",
                {"kernel": 3, "resolution": 1024},
                np.clip(0.5 + distance / 0.5, 0, 1),
                7.0,
                ("kernel", 3),
            ),
            (
                "pcf",
                "Percentage closer filtering",
                {"kernel": 17, "resolution": 1024},
                np.clip(0.5 + distance / 1.6, 0, 1),
                17.5,
                ("kernel", 17),
            ),
            ("light_samples", "Light samples", {"samples": 16}, np.round(truth * 16) / 16, 88.0, None),
            ("light_samples", "Light samples", {"samples": 64}, np.round(truth * 64) / 64, 351.0, ("samples", 64)),
            ("ray_traced", "Ray traced", {"rays": 16, "seed": 1}, generator.binomial(16, truth) / 16, 31.0, None),
            ("ray_traced", "Ray traced", {"rays": 4, "seed": 1}, generator.binomial(4, truth) / 4, 9.2, ("rays", 4)),
            (
                "ray_traced",
                "Ray traced",
                {"rays": 64, "seed": 1},
                generator.binomial(64, truth) / 64,
                118.0,
                ("rays", 64),
            ),
        ]
        for technique, title, settings, values, cost, sweep in candidates:
            image = np.where(mask > 0, values, 1).astype(np.float32)
            record = Record(
                technique, title, dict(settings), sweep=sweep_entry({sweep[0]: sweep[1]}) if sweep else None
            )
            record.area = errors_of(image, truth, noise, mask)
            record.irradiance = errors_of(image, irradiance_truth, noise, mask)
            record.given = {sweep[0]: sweep[1]} if sweep else {}
            record.headline_error = precision.headline_error([image], truth, noise, mask)
            record.flip = 0.4 * record.area["rmse"]
            record.time_ms = {
                "setup": spread(14.0),
                "dynamic": spread(cost, tight=True),
                "static": spread(cost * 0.7, tight=technique != "pcf"),
                "kept": spread(0.06),
                "view": spread(4.2),
            }
            if technique == "shadow_map":
                record.everything_ms = {"dynamic": spread(2.0 * cost), "static": spread(cost)}
            elif technique == "pcf":
                record.everything_ms = {"dynamic": spread(1.01 * cost), "static": spread(cost)}
            record.memory_bytes = 4 << 20
            record.statistics = [
                Statistic("rays", "Rays cast", "rays", 1234567.0),
                Statistic("tagged", "Tagged pixels", "share of the mask", 0.0512),
            ]
            record.plan = [
                Step("depth map", "run", time_ms=cost * 0.3),
                Step("lookup", "run", time_ms=cost * 0.7),
                Step("face +x", "left_out", "no visible receiver lies in it", "cube_faces", 0.0),
                Step("penumbra filter", "left_out", "the penumbra is 0.3 texels wide at most", "narrow", 0.004),
            ]
            if technique == "shadow_map":
                record.warnings = ["the light is 1 m wide and <one> point stands for it"]
            record.visibility = None if sweep else image
            light.records.append(record)
        light.records.append(
            Record(
                "linear_light_maps", "Linear light maps", {}, "unsupported", "it serves line lights, not a rectangle"
            )
        )
        verdict.judge(light, 0.05, staircase)
        scene.lights.append(light)
    return scene


def staircase(times: list[float], errors: list[float]) -> list[bool]:
    """core.pareto_front in one line."""
    points = list(zip(times, errors, strict=True))
    return [not any(a <= t and b <= e and (a < t or b < e) for a, b in points) for t, e in points]


ENVIRONMENT = {
    "penumbra": "0.1.0",
    "commit": "0123456789abcdef",
    "build": {"compiler": "GCC 12.2"},
    "cpu": "Some CPU",
    "cores": 2,
    "memory_bytes": 8 << 30,
    "os": "Debian GNU/Linux 12 (bookworm)",
    "python": "3.11.7",
    "blender": "4.5.15 LTS",
    "date": "2026-01-02T03:04:05+00:00",
    "command": "penumbra compare 'ramps & <walls>.blend' --out out",
    "gl_renderer": "llvmpipe (LLVM 15.0.6, 256 bits)",
    "gl_version": "4.5 (Core Profile) Mesa 22.3.6",
    "gl_vendor": "Mesa",
    "software": True,
    "device": "0",
    "threads": 2,
    "embree": "3.13.5",
    "view_by": "raster",
}


def ramp_comparison() -> Comparison:
    """Environment and options without scenes; add them with ramp_scene(), then summarise()."""
    return Comparison(environment=dict(ENVIRONMENT), options={"sweep": "quick", "target_rmse": 0.05})


def summarise(comparison: Comparison) -> None:
    together.summarise(comparison, 0.05)
