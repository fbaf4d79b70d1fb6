# SPDX-License-Identifier: Apache-2.0
"""Config, presets, rigs, errors and the names of the package."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import stereogrid as sg


def rig(**changes: Any) -> sg.Rig:
    values = {"width_px": 256, "height_px": 160, "focal_px": 205, "cx_px": 128, "cy_px": 80}
    return sg.Rig(**{**values, "baseline_m": 0.22, **changes})  # type: ignore[arg-type]


def test_groups_and_keys() -> None:
    config = sg.preset("default")
    for key in sg.Config.keys():
        group, name = key.split(".")
        assert config.get(key) == getattr(getattr(config, group), name)
    config.grid.cell_size_m = 0.1
    assert config.get("grid.cell_size_m") == 0.1
    config.set("grid.cell_size_m", 0.25)
    config.set("filter.model", "tay2008")
    config.set("ground.estimate", False)
    config.set("grid.length_m", "30")
    assert config.grid.cell_size_m == 0.25 and config.grid.length_m == 30
    assert config.filter.model == "tay2008" and config.ground.estimate is False


def test_every_key_can_be_set_to_its_value() -> None:
    for name in sg.preset_names():
        config, other = sg.preset(name), sg.Config()
        for key in sg.Config.keys():
            other.set(key, config.get(key))
        assert other == config


def test_docstrings_come_from_the_declaration() -> None:
    doc = type(sg.Config().grid).cell_size_m.__doc__
    assert doc is not None and "Side of a square cell. Unit: m." in doc


def test_mistakes() -> None:
    config = sg.preset("default")
    with pytest.raises(sg.ConfigError, match=r"grid.cell_size_m"):
        config.set("grid.cell_siz_m", 1)
    with pytest.raises(sg.ConfigError):
        config.get("nothing")
    with pytest.raises(sg.ConfigError):
        config.filter.model = "none"
    with pytest.raises(sg.ConfigError):
        config.grid.length_m = "far"
    with pytest.raises(AttributeError):
        config.grid.cell_siz_m = 1  # type: ignore[attr-defined]
    with pytest.raises(sg.ConfigError):
        sg.preset("none")
    config.grid.length_m = 100000
    assert config.problems()
    with pytest.raises(sg.ConfigError, match=r"grid.length_m"):
        sg.Pipeline(config, rig())
    assert sg.preset("default").problems() == []


def test_files(tmp_path: Path) -> None:
    config = sg.preset("paper")
    config.grid.length_m = 12.5
    (tmp_path / "config.yaml").write_text(config.to_yaml())
    read = sg.Config()
    read.load(tmp_path / "config.yaml")
    assert read == config != sg.preset("paper")
    (tmp_path / "config.yaml").write_text("grid: {size: 3}")
    with pytest.raises(sg.ConfigError, match=r"config.yaml"):
        read.load(tmp_path / "config.yaml")


def test_copies() -> None:
    config = sg.preset("robot")
    config.grid.length_m = 7.3
    for other in (config.copy(), copy.copy(config), copy.deepcopy(config), pickle.loads(pickle.dumps(config))):
        assert other == config
        other.grid.length_m = 1
        assert other != config
    assert config.grid.length_m == 7.3


def test_rig() -> None:
    mask = np.full((160, 256), 255, np.uint8)
    mask[150:] = 0
    made = rig(extrinsics_given=False, mask=mask)
    for other in (made, pickle.loads(pickle.dumps(made))):
        assert other.mask is not None
        np.testing.assert_array_equal(other.mask, mask)
        assert other.focal_px == 205 and not other.extrinsics_given and other.camera_height_m == 1.65
    made.mask = None
    assert made.mask is None
    with pytest.raises(sg.ConfigError, match="baseline"):
        sg.Pipeline(sg.preset("default"), rig(baseline_m=220))
    assert rig(baseline_m=220).problems() and not rig().problems()
    with pytest.raises(sg.ConfigError, match="device gpu"):
        sg.Pipeline(sg.preset("default"), rig(), device="gpu")


def test_poses() -> None:
    a = sg.Pose(1, 2, 0.5)
    product = a * a.inverse()
    assert abs(product.x_m) < 1e-12 and abs(product.y_m) < 1e-12 and abs(product.yaw_rad) < 1e-12
    assert pickle.loads(pickle.dumps(a)) == a
    camera = [0, 0, 1, 4, -1, 0, 0, 5, 0, -1, 0, 6]
    assert isinstance(sg.Pose.from_camera(camera), sg.Pose)
    with pytest.raises(TypeError):
        sg.Pose.from_camera([1, 2, 3])


def test_errors() -> None:
    assert issubclass(sg.ConfigError, (sg.Error, ValueError)) and issubclass(sg.ConfigError, ValueError)
    assert issubclass(sg.InputError, sg.Error) and issubclass(sg.InputError, ValueError)
    assert issubclass(sg.DeviceError, sg.Error) and issubclass(sg.DeviceError, OSError)
    with pytest.raises(sg.InputError, match="nowhere"):
        sg.open("nowhere")


def test_stubs_name_every_public_class_and_function() -> None:
    package = Path(sg.__file__).parent
    assert (package / "py.typed").exists()
    stub = (package / "_core.pyi").read_text()
    for name in set(sg.__all__) - {"evaluate", "run"}:
        assert f"class {name}" in stub or f"def {name}(" in stub or f"\n{name}" in stub, name
    assert "object" not in stub.split("class Pipeline")[1].split("class ")[0]
