"""
Penumbra's core: soft-shadow techniques, their reference and their measures. Forwards to C++.
"""

from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing

__all__: list[str] = [
    "Camera",
    "Cancelled",
    "DeviceError",
    "Error",
    "InvalidScene",
    "InvalidSettings",
    "Light",
    "Mesh",
    "OutOfMemory",
    "Renderer",
    "Scene",
    "View",
    "build_info",
    "device_problem",
    "devices",
    "embree_version",
    "exact_visibility",
    "measure_errors",
    "pareto_front",
    "rules",
    "techniques",
]

class Error(RuntimeError):
    pass

class InvalidScene(Error):
    pass

class InvalidSettings(Error):
    pass

class DeviceError(Error):
    pass

class OutOfMemory(Error):
    pass

class Cancelled(Error):
    pass

class Light:
    """
    One light, in world space: metres, radians, watts. See cpp/include/penumbra/light.h.
    """

    casts_shadow: bool
    kind: str
    name: str
    def __init__(self) -> None: ...
    @property
    def corners_ws(self) -> list[typing.Annotated[list[float], "FixedSize(3)"]]: ...
    @corners_ws.setter
    def corners_ws(
        self, arg1: collections.abc.Sequence[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]]
    ) -> None: ...
    @property
    def direction_ws(self) -> typing.Annotated[list[float], "FixedSize(3)"]: ...
    @direction_ws.setter
    def direction_ws(self, arg1: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> None: ...
    @property
    def half_u_ws(self) -> typing.Annotated[list[float], "FixedSize(3)"]: ...
    @half_u_ws.setter
    def half_u_ws(self, arg1: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> None: ...
    @property
    def half_v_ws(self) -> typing.Annotated[list[float], "FixedSize(3)"]: ...
    @half_v_ws.setter
    def half_v_ws(self, arg1: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> None: ...
    @property
    def position_ws(self) -> typing.Annotated[list[float], "FixedSize(3)"]: ...
    @position_ws.setter
    def position_ws(self, arg1: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> None: ...
    @property
    def power_w(self) -> typing.Annotated[list[float], "FixedSize(3)"]: ...
    @power_w.setter
    def power_w(self, arg1: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex]) -> None: ...
    @property
    def radius_m(self) -> float: ...
    @radius_m.setter
    def radius_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def spot_angle_rad(self) -> float: ...
    @spot_angle_rad.setter
    def spot_angle_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def spot_blend(self) -> float: ...
    @spot_blend.setter
    def spot_blend(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def spot_stretch(self) -> typing.Annotated[list[float], "FixedSize(2)"]: ...
    @spot_stretch.setter
    def spot_stretch(
        self,
        arg1: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"],
    ) -> None: ...
    @property
    def sun_angle_rad(self) -> float: ...
    @sun_angle_rad.setter
    def sun_angle_rad(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class Camera:
    """
    Looks along its local -z, +y up. See cpp/include/penumbra/scene.h.
    """

    name: str
    orthographic: bool
    def __init__(self) -> None: ...
    @property
    def far_m(self) -> float: ...
    @far_m.setter
    def far_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def half_width_m(self) -> float: ...
    @half_width_m.setter
    def half_width_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def height_px(self) -> int: ...
    @height_px.setter
    def height_px(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def near_m(self) -> float: ...
    @near_m.setter
    def near_m(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def pixel_aspect(self) -> float: ...
    @pixel_aspect.setter
    def pixel_aspect(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def pixel_offset(self) -> typing.Annotated[list[float], "FixedSize(2)"]: ...
    @pixel_offset.setter
    def pixel_offset(
        self,
        arg1: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"],
    ) -> None: ...
    @property
    def shift(self) -> typing.Annotated[list[float], "FixedSize(2)"]: ...
    @shift.setter
    def shift(
        self,
        arg1: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"],
    ) -> None: ...
    @property
    def tan_half_width(self) -> float: ...
    @tan_half_width.setter
    def tan_half_width(self, arg0: typing.SupportsFloat | typing.SupportsIndex) -> None: ...
    @property
    def width_px(self) -> int: ...
    @width_px.setter
    def width_px(self, arg0: typing.SupportsInt | typing.SupportsIndex) -> None: ...
    @property
    def world_from_camera(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @world_from_camera.setter
    def world_from_camera(self, arg1: typing.Annotated[numpy.typing.ArrayLike, numpy.float64]) -> None: ...

class Mesh:
    """
    Triangles in their own space, shared by all their instances.
    """
    def __init__(
        self,
        name: str,
        positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
        triangles: typing.Annotated[numpy.typing.ArrayLike, numpy.uint32],
        corner_normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float32] | None = None,
        triangle_material: typing.Annotated[numpy.typing.ArrayLike, numpy.uint16] | None = None,
    ) -> None:
        """
        positions (n, 3) float32; triangles (m, 3) uint32; corner_normals (3 m, 3) float32 or None (flat);
        triangle_material (m,) uint16 or None. Raises InvalidScene for indices out of range, NaN or wrong shapes.
        """
    @property
    def name(self) -> str: ...
    @property
    def triangle_count(self) -> int: ...
    @property
    def vertex_count(self) -> int: ...

class Scene:
    """
    What is rendered: instances, lights, one camera.
    """

    camera: Camera
    def __init__(self) -> None: ...
    def add_instance(
        self,
        name: str,
        mesh: Mesh,
        world_from_local: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
        albedo: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
        casts: bool = True,
        receives: bool = True,
        visible: bool = True,
    ) -> None:
        """
        world_from_local (4, 4) float64; albedo (k, 3) float32, linear, one row per material slot.
        """
    def add_light(self, light: Light) -> None: ...
    def copy(self) -> Scene:
        """
        Another scene with the same meshes: what is changed in one of them does not change the other.
        """
    def digest(self) -> str:
        """
        Hash over all that influences an image: equal digests give equal images.
        """
    def set_transform(
        self,
        instance: typing.SupportsInt | typing.SupportsIndex,
        world_from_local: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    ) -> None:
        """
        Moves an instance, counted from 0 in the order they were added; (4, 4) float64.
        """
    def validate(self) -> None: ...
    @property
    def instance_count(self) -> int: ...
    @property
    def lights(self) -> list[Light]: ...
    @lights.setter
    def lights(self, arg0: collections.abc.Sequence[Light]) -> None: ...
    @property
    def triangle_count(self) -> int: ...

class View:
    """
    G-buffer at the pixel samples; row 0 is the bottom row, lengths in metres.
    """
    @property
    def albedo(self) -> numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]: ...
    @property
    def eye_ws(self) -> typing.Annotated[list[float], "FixedSize(3)"]: ...
    @property
    def height(self) -> int: ...
    @property
    def instance(self) -> numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]: ...
    @property
    def normal_ws(self) -> numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]: ...
    @property
    def position_cr(self) -> numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]: ...
    @property
    def shading_normal_ws(self) -> numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]: ...
    @property
    def time_ms(self) -> float: ...
    @property
    def triangle(self) -> numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]: ...
    @property
    def width(self) -> int: ...

class Renderer:
    """
    Renders one scene on one device, on a thread of its own. Long calls release the GIL, hear
    Ctrl-C, and tell progress(fraction, text) if it is given.
    """
    def __init__(
        self,
        device: str = "",
        debug: bool = False,
        most_kept_bytes: typing.SupportsInt | typing.SupportsIndex = 268435456,
        view_by: str = "raster",
    ) -> None:
        """
        device: "" (automatic), an index, or part of a renderer's name. Raises DeviceError.
        most_kept_bytes: of the frames that visibility(reuse=True) keeps, in main memory.
        view_by: "raster" draws what the camera sees; "rays" traces it, which is faster without a graphics
        card where meshes are heavy and stand still.
        """
    def bake(
        self,
        light: typing.SupportsInt | typing.SupportsIndex,
        technique: str,
        settings: dict = {},
        progress: typing.Any = None,
    ) -> list:
        """
        The technique's textures of V on surfaces: {name, visibility (h, w) float32, corners_ws: world positions
        of the image's corners at the UVs (0, 0), (1, 0), (1, 1), (0, 1)}; empty if it makes none.
        """
    def debug_images(
        self,
        light: typing.SupportsInt | typing.SupportsIndex,
        technique: str,
        settings: dict = {},
        views: collections.abc.Sequence[str] = [],
        progress: typing.Any = None,
    ) -> list:
        """
        Pictures of the technique's inside: {id, title, caption, rgb (h, w, 3) float32, display values 0 .. 1}.
        views: ids, default all that the plan offers.
        """
    def irradiance(
        self, light: typing.SupportsInt | typing.SupportsIndex, progress: typing.Any = None
    ) -> numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]:
        """
        Analytic unshadowed irradiance (h, w, 3) float32, W/m^2.
        """
    def mask(
        self, light: typing.SupportsInt | typing.SupportsIndex
    ) -> numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]:
        """
        (h, w) uint8: 1 where this light's visibility is asked.
        """
    def measure(
        self,
        light: typing.SupportsInt | typing.SupportsIndex,
        jobs: collections.abc.Sequence[tuple[str, dict]],
        keep_everything: bool = False,
        max_seconds: typing.SupportsFloat | typing.SupportsIndex = 4.0,
        min_runs: typing.SupportsInt | typing.SupportsIndex = 5,
        max_runs: typing.SupportsInt | typing.SupportsIndex = 200,
        progress: typing.Any = None,
        keep_rules: collections.abc.Sequence[collections.abc.Sequence[str]] = [],
    ) -> list:
        """
        Times of (technique, settings) jobs, measured interleaved; milliseconds.
        keep_rules: for each job the rules that must leave nothing out; ["all"] for all of them.
        """
    def reference(
        self,
        light: typing.SupportsInt | typing.SupportsIndex,
        standard_error: typing.SupportsFloat | typing.SupportsIndex = 0.002,
        seed: typing.SupportsInt | typing.SupportsIndex = 1,
        max_rays_per_pixel: typing.SupportsInt | typing.SupportsIndex = 65536,
        keep_everything: bool = False,
        exact: bool = False,
        progress: typing.Any = None,
    ) -> dict:
        """
        The truth by ray tracing to a standard error: area and irradiance (h, w) float32, and more.
        exact: float64 boundary intervals instead, for rectangle and polygon lights.
        """
    def set_scene(self, scene: Scene) -> None:
        """
        Checks the scene and makes it current. Raises InvalidScene.
        """
    def summary(self, light: typing.SupportsInt | typing.SupportsIndex, keep_everything: bool = False) -> dict: ...
    def supports(self, light: typing.SupportsInt | typing.SupportsIndex, technique: str) -> str:
        """
        Empty, or why the technique cannot serve the light.
        """
    def view(self, progress: typing.Any = None) -> View: ...
    def visibility(
        self,
        light: typing.SupportsInt | typing.SupportsIndex,
        technique: str,
        settings: dict = {},
        keep_everything: bool = False,
        statistics: bool = True,
        progress: typing.Any = None,
        reuse: bool = False,
        keep_rules: collections.abc.Sequence[str] = [],
    ) -> dict:
        """
        {visibility (h, w) float32 0 umbra .. 1 lit, settings, plan, warnings, statistics,
        memory_bytes, time_ms, kept}; warnings {id, reason}: where the technique leaves its field of use.
        statistics: count what the frame did, which may cost as much as the frame.
        reuse: keep V, and hand over an earlier frame's if view, light, casters and settings are the same.
        keep_rules: ids of rules that must leave nothing out.
        """
    def work(self) -> dict:
        """
        What it has done so far: programs compiled, views drawn, frames made and kept, and more.
        """
    @property
    def environment(self) -> dict: ...

def build_info() -> dict:
    """
    Version, compiler and language standard of this build.
    """

def device_problem() -> str:
    """
    Why devices() is empty, in one sentence, or an empty string.
    """

def devices() -> list:
    """
    All EGL devices, usable or not; empty without libEGL.
    """

def embree_version() -> str:
    """
    Version of the Embree in use; raises DeviceError if there is none.
    """

def exact_visibility(
    scene: Scene,
    light: typing.SupportsInt | typing.SupportsIndex,
    positions: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
    normals: typing.Annotated[numpy.typing.ArrayLike, numpy.float64],
) -> dict:
    """
    Exact visibility and irradiance ratio of a rectangle or polygon light at points (n, 3) float64, world.
    """

def measure_errors(
    visibility: collections.abc.Sequence[typing.Annotated[numpy.typing.ArrayLike, numpy.float32]],
    reference: typing.Annotated[numpy.typing.ArrayLike, numpy.float32],
    standard_error: typing.Annotated[numpy.typing.ArrayLike, numpy.float32] | None,
    mask: typing.Annotated[numpy.typing.ArrayLike, numpy.uint8],
) -> dict:
    """
    Errors of V against the reference over the mask; definitions in docs/measuring.md.
    visibility: one (h, w) float32 image per seed; reference, standard_error (or None): (h, w) float32;
    mask: (h, w) uint8.
    """

def pareto_front(
    times_ms: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
    errors: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
) -> list[bool]:
    """
    True for each record that no other beats in both time and error.
    """

def rules() -> list:
    """
    All rules that leave work out: id, condition, tolerance of V, stage of a frame, and the techniques it can fire in.
    """

def techniques() -> list:
    """
    All techniques with their settings, in the order users see them.
    """

__version__: str = "0.1.0"
