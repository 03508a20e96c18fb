"""What one viewport hides by its own choice stays out of its picture, and of no other."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace
from typing import Any

import bpy
import pytest
from blender_kit import Kit
from penumbra import bridge
from penumbra.read import view_region
from penumbra.sync import SceneSync
from penumbra.viewport import overlay
from penumbra.viewport.engine_view import EngineView


@pytest.fixture
def space(kit: Kit) -> Iterator[Any]:
    """A 3D viewport of the factory settings' screen; a floor, two boxes in collections of their own, a lamp."""
    kit.plane("Floor", half=5)
    for name in ("Left", "Right"):
        box = kit.cube(name, half=0.3, at=(-1 if name == "Left" else 1, 0, 1))
        collection = bpy.data.collections.new(f"{name}s")
        kit.scene.collection.children.link(collection)
        collection.objects.link(box)
        kit.scene.collection.objects.unlink(box)
    kit.light("POINT", name="Lamp", at=(0, 0, 4))
    kit.camera()
    bpy.context.view_layer.update()
    area = _area()
    yield area.spaces.active
    _area().spaces.active.use_local_collections = False


def _area() -> Any:
    screen = bpy.context.window_manager.windows[0].screen
    return next(area for area in screen.areas if area.type == "VIEW_3D")


def enter_local_view(*names: str) -> None:
    for obj in bpy.context.view_layer.objects:
        obj.select_set(obj.name in names)
    window, area = bpy.context.window_manager.windows[0], _area()
    region = next(region for region in area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=area, region=region, space_data=area.spaces.active):
        assert bpy.ops.view3d.localview(frame_selected=False) == {"FINISHED"}


def seen(sync: SceneSync, space: Any | None) -> tuple[list[str], list[str]]:
    """Names of the objects and of the lights that cross, those of a read from scratch."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    export = sync.update(depsgraph, space)
    fresh = bridge.Reader(depsgraph, depsgraph.scene_eval, space=space).read(None, None)
    assert export.scene.digest() == fresh.scene.digest()
    return sorted(export.instance_names), sorted(export.lights)


def test_local_view_shows_what_is_in_it_and_other_viewports_show_all(kit: Kit, space: Any) -> None:
    local, other = SceneSync(), SceneSync()
    assert seen(local, space) == (["Floor", "Left", "Right"], ["Lamp"])
    enter_local_view("Floor", "Left", "Lamp")
    assert seen(local, space) == (["Floor", "Left"], ["Lamp"])
    assert seen(other, None) == (["Floor", "Left", "Right"], ["Lamp"])
    enter_local_view()  # the same operator leaves it
    assert seen(local, space) == (["Floor", "Left", "Right"], ["Lamp"])


def test_an_object_that_joins_the_local_view_appears(kit: Kit, space: Any) -> None:
    sync = SceneSync()
    enter_local_view("Floor", "Lamp")
    assert seen(sync, space)[0] == ["Floor"]
    bpy.data.objects["Right"].local_view_set(space, True)
    bpy.context.view_layer.update()
    assert seen(sync, space)[0] == ["Floor", "Right"]


def test_types_of_objects_that_a_viewport_hides_stay_out(kit: Kit, space: Any) -> None:
    sync = SceneSync()
    space.show_object_viewport_light = False
    assert seen(sync, space) == (["Floor", "Left", "Right"], ["placed light"])
    space.show_object_viewport_light, space.show_object_viewport_mesh = True, False
    assert seen(sync, space) == ([], ["Lamp"])
    space.show_object_viewport_mesh = True


def test_a_collection_hidden_in_the_view_layer_stays_out(kit: Kit, space: Any) -> None:
    sync = SceneSync()
    layer = bpy.context.view_layer.layer_collection.children["Lefts"]
    for switch in ("hide_viewport", "exclude"):
        setattr(layer, switch, True)
        bpy.context.view_layer.update()
        assert seen(sync, space)[0] == ["Floor", "Right"], switch
        setattr(layer, switch, False)
        bpy.context.view_layer.update()
        assert seen(sync, space)[0] == ["Floor", "Left", "Right"], switch
    bpy.data.collections["Lefts"].hide_viewport = True
    bpy.context.view_layer.update()
    assert seen(sync, space)[0] == ["Floor", "Right"]


def test_an_object_hidden_with_h_stays_out_of_viewports_and_in_the_render(kit: Kit, space: Any) -> None:
    bpy.data.objects["Left"].hide_set(True)
    bpy.context.view_layer.update()
    assert seen(SceneSync(), space)[0] == ["Floor", "Right"]
    assert sorted(kit.read().instance_names) == ["Floor", "Left", "Right"]


def test_instances_obey_the_object_that_makes_them(kit: Kit, space: Any) -> None:
    maker = kit.object("Maker", None, at=(0, 3, 0))
    maker.instance_type, maker.instance_collection = "COLLECTION", bpy.data.collections["Lefts"]
    bpy.context.view_layer.update()
    sync = SceneSync()
    assert "Maker / Left 1" in seen(sync, space)[0]
    enter_local_view("Floor", "Lamp")
    assert seen(sync, space)[0] == ["Floor"]
    maker.local_view_set(space, True)
    bpy.context.view_layer.update()
    assert seen(sync, space)[0] == ["Floor", "Maker / Left 1"]


def test_what_only_redraws_a_viewport_is_noticed_when_it_draws(
    kit: Kit, space: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Blender calls view_draw alone when a viewport hides a type of objects."""
    read: list[tuple[Any, ...]] = []
    monkeypatch.setattr(EngineView, "_put_up", lambda *_: None)
    monkeypatch.setattr(view_region, "seen_part", lambda _context: None)

    class Engine:
        pass

    view = EngineView(Engine())
    context = SimpleNamespace(space_data=space, scene=kit.scene)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    real = SceneSync.update
    monkeypatch.setattr(
        SceneSync, "update", lambda self, *given: read.append(view_region.own_choice(space)) or real(self, *given)
    )
    view.update(context, depsgraph)
    view.draw(context, depsgraph)
    assert len(read) == 1, "nothing changed"
    space.show_object_viewport_mesh = False
    view.draw(context, depsgraph)
    view.draw(context, depsgraph)
    space.show_object_viewport_mesh = True
    assert len(read) == 2
    view.close()


def test_a_viewport_that_hides_something_is_told_from_one_that_shows_all(kit: Kit, space: Any) -> None:
    """The overlay keeps a scene of its own for one that does."""
    assert not view_region.hides_something(None)
    assert not view_region.hides_something(space)
    space.show_object_viewport_light = False
    assert view_region.hides_something(space)
    space.show_object_viewport_light = True
    enter_local_view("Floor")
    assert view_region.hides_something(space)
    enter_local_view()
    space.use_local_collections = True
    assert view_region.hides_something(space)


@pytest.fixture
def overlaid(kit: Kit, space: Any) -> Iterator[Any]:
    """What the overlay's drawing handler sees of Blender; there is nothing to draw on in the background."""
    bpy.app.handlers.depsgraph_update_post.append(overlay._changed)
    yield SimpleNamespace(space_data=space, view_layer=bpy.context.view_layer)
    overlay.switch_off()
    assert not overlay._state.scenes


def overlay_sees(context: Any) -> tuple[list[str], list[str]]:
    scene = overlay._scene_of(context)
    assert not scene.problem
    export = scene.sync.export
    assert export is not None
    return sorted(export.instance_names), sorted(export.lights)


def test_the_overlay_shows_what_its_viewport_shows(space: Any, overlaid: Any) -> None:
    everything = (["Floor", "Left", "Right"], ["Lamp"])
    assert overlay_sees(overlaid) == everything
    enter_local_view("Floor", "Left", "Lamp")
    assert overlay_sees(overlaid) == (["Floor", "Left"], ["Lamp"])
    enter_local_view()
    assert overlay_sees(overlaid) == everything
    space.show_object_viewport_mesh = False
    assert overlay_sees(overlaid) == ([], ["Lamp"])
    space.show_object_viewport_mesh = True
    assert overlay_sees(overlaid) == everything
    assert len(overlay._state.scenes) == 1, "what a viewport hid before is not kept"


def test_the_overlay_follows_changes_in_a_local_view(space: Any, overlaid: Any) -> None:
    enter_local_view("Floor", "Left", "Lamp")
    before = overlay._scene_of(overlaid)
    revision, digest = before.revision, before.sync.export.scene.digest()
    bpy.data.objects["Left"].location = (-2, 0, 1)
    bpy.context.view_layer.update()
    scene = overlay._scene_of(overlaid)
    assert scene is before and scene.revision > revision
    assert scene.sync.export.scene.digest() != digest
    assert overlay_sees(overlaid) == (["Floor", "Left"], ["Lamp"])
    bpy.data.objects["Right"].local_view_set(space, True)
    bpy.context.view_layer.update()
    assert overlay_sees(overlaid) == (["Floor", "Left", "Right"], ["Lamp"])
