from __future__ import annotations

import multiprocessing
import os
from pathlib import Path

import numpy as np
import pytest
from penumbra import cache
from penumbra.cache import ReferenceCache
from penumbra.errors import UserError
from penumbra.records import ReferenceResult


def reference(value: float = 0.25, shape: tuple[int, int] = (6, 8)) -> ReferenceResult:
    image = np.full(shape, value, np.float32)
    return ReferenceResult(
        method="ray traced",
        area=image,
        irradiance=image + 0.1,
        standard_error=image * 0.01,
        irradiance_standard_error=image * 0.02,
        mask=np.ones(shape, np.uint8),
        rays=12345,
        mean_rays_per_pixel=77.5,
        standard_error_asked=0.002,
        time_ms=12.5,
        reached=True,
        pixels_skipped=3,
    )


def test_what_was_stored_comes_back_bit_for_bit_and_is_marked(tmp_path: Path) -> None:
    store = ReferenceCache(tmp_path)
    kept = reference()
    assert store.store("key", kept)
    found = store.load("key")
    assert found is not None
    assert found.from_cache
    for name in ("area", "irradiance", "standard_error", "irradiance_standard_error", "mask"):
        assert np.array_equal(getattr(found, name), getattr(kept, name))
        assert getattr(found, name).dtype == getattr(kept, name).dtype
    assert (found.method, found.rays, found.reached, found.pixels_skipped) == ("ray traced", 12345, True, 3)


def test_another_key_is_a_miss(tmp_path: Path) -> None:
    store = ReferenceCache(tmp_path)
    store.store("key", reference())
    assert store.load("another") is None


def test_every_part_of_a_key_changes_it() -> None:
    parts = {"core": "1", "scene": "abc", "light": 0, "standard_error": 0.002, "seed": 1, "keep_everything": False}
    base = cache.key(**parts)
    changes = {"core": "2", "scene": "abd", "light": 1, "standard_error": 0.001, "seed": 2, "keep_everything": True}
    assert len({base} | {cache.key(**(parts | {name: value})) for name, value in changes.items()}) == 7
    assert cache.key(**dict(reversed(parts.items()))) == base


@pytest.mark.parametrize("damage", ["cut", "flip", "empty", "text", "other key"])
def test_a_damaged_entry_is_a_miss_and_is_removed(tmp_path: Path, damage: str) -> None:
    store = ReferenceCache(tmp_path)
    store.store("key", reference())
    (path,) = tmp_path.iterdir()
    data = path.read_bytes()
    if damage == "flip":
        middle = len(data) // 2
        data = data[:middle] + bytes([data[middle] ^ 255]) + data[middle + 1 :]
    path.write_bytes({"cut": data[: len(data) // 2], "flip": data, "empty": b"", "text": b"hello"}.get(damage, data))
    if damage == "other key":
        path.rename(path.with_name(path.name.replace("key", "other")))
        assert store.load("other") is None
        return
    assert store.load("key") is None
    assert not path.exists()
    assert store.store("key", reference())
    assert store.load("key") is not None


def test_what_was_unused_for_longest_goes_first(tmp_path: Path) -> None:
    store = ReferenceCache(tmp_path)
    store.store("a", reference())
    size = store.size_bytes()
    small = ReferenceCache(tmp_path, max_bytes=3 * size)
    for age, entry in ((300, "a"), (200, "b"), (100, "c")):
        small.store(entry, reference())
        path = next(item for item in tmp_path.iterdir() if item.name.startswith(entry))
        os.utime(path, (path.stat().st_atime - age, path.stat().st_mtime - age))
    assert small.load("a") is not None  # used again: now the youngest
    small.store("d", reference())
    assert [small.load(entry) is not None for entry in "abcd"] == [True, False, True, True]
    assert small.size_bytes() <= small.max_bytes


def test_an_entry_larger_than_the_cap_is_not_kept_and_removes_nothing(tmp_path: Path) -> None:
    ReferenceCache(tmp_path).store("a", reference())
    size = ReferenceCache(tmp_path).size_bytes()
    small = ReferenceCache(tmp_path, max_bytes=size + 10)
    assert not small.store("big", reference(shape=(100, 100)))
    assert small.load("a") is not None


def test_a_folder_that_cannot_be_written_caches_nothing_and_raises_nothing() -> None:
    store = ReferenceCache(Path("/proc/penumbra"))
    assert not store.store("key", reference())
    assert store.load("key") is None
    assert store.entries() == 0


def _hammer(folder: str, worker: int) -> int:
    store = ReferenceCache(Path(folder), max_bytes=40_000)
    wrong = 0
    for i in range(60):
        name = f"k{(i + worker) % 7}"
        store.store(name, reference(value=0.5))
        found = store.load(name)
        if found is not None and not np.all(found.area == np.float32(0.5)):
            wrong += 1
    return wrong


def test_processes_that_share_a_folder_never_see_a_part_of_an_entry(tmp_path: Path) -> None:
    with multiprocessing.get_context("spawn").Pool(3) as pool:
        assert pool.starmap(_hammer, [(str(tmp_path), worker) for worker in range(3)]) == [0, 0, 0]
    assert all(path.name.endswith(".reference.npz") for path in tmp_path.iterdir())


def test_the_folder_is_ours_then_xdg_then_home(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PENUMBRA_CACHE", "/own")
    monkeypatch.setenv("XDG_CACHE_HOME", "/xdg")
    assert cache.folder() == Path("/own")
    monkeypatch.delenv("PENUMBRA_CACHE")
    assert cache.folder() == Path("/xdg/penumbra")
    monkeypatch.delenv("XDG_CACHE_HOME")
    assert cache.folder() == Path.home() / ".cache" / "penumbra"


@pytest.mark.parametrize(
    ("text", "size"),
    [("", 2 << 30), ("1000", 1000), ("500M", 500 << 20), ("1.5GiB", 3 << 29), ("2gb", 2 << 30), ("0", 0)],
)
def test_the_cap_is_read_with_units(monkeypatch: pytest.MonkeyPatch, text: str, size: int) -> None:
    monkeypatch.setenv("PENUMBRA_CACHE_SIZE", text)
    assert cache.capacity() == size


@pytest.mark.parametrize("text", ["lots", "-1", "5X", "nan", "inf"])
def test_a_cap_that_is_no_size_is_one_sentence(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setenv("PENUMBRA_CACHE_SIZE", text)
    with pytest.raises(UserError, match="PENUMBRA_CACHE_SIZE"):
        cache.capacity()
