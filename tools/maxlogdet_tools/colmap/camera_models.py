# SPDX-License-Identifier: MIT
"""COLMAP's camera models, and which of those of frames they are."""

from typing import NamedTuple

from maxlogdet_tools.colmap.model_file import InputError


class Model(NamedTuple):
    number: int  # MODEL_ID in binary files
    parameters: str  # names in COLMAP's order
    frame_model: str | None  # the same projection in frames; None: there is none


MODELS = {
    "SIMPLE_PINHOLE": Model(0, "f cx cy", "pinhole"),
    "PINHOLE": Model(1, "fx fy cx cy", "pinhole"),
    "SIMPLE_RADIAL": Model(2, "f cx cy k1", "radial_tangential"),
    "RADIAL": Model(3, "f cx cy k1 k2", "radial_tangential"),
    "OPENCV": Model(4, "fx fy cx cy k1 k2 p1 p2", "radial_tangential"),
    "OPENCV_FISHEYE": Model(5, "fx fy cx cy k1 k2 k3 k4", "kannala_brandt"),
    "FULL_OPENCV": Model(6, "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6", "radial_tangential"),
    "FOV": Model(7, "fx fy cx cy omega", None),
    "SIMPLE_RADIAL_FISHEYE": Model(8, "f cx cy k1", "kannala_brandt"),
    "RADIAL_FISHEYE": Model(9, "f cx cy k1 k2", "kannala_brandt"),
    "THIN_PRISM_FISHEYE": Model(10, "fx fy cx cy k1 k2 p1 p2 k3 k4 sx1 sy1", None),
    "RAD_TAN_THIN_PRISM_FISHEYE": Model(11, "fx fy cx cy k0 k1 k2 k3 k4 k5 p0 p1 s0 s1 s2 s3", None),
    "SIMPLE_DIVISION": Model(12, "f cx cy k", None),
    "DIVISION": Model(13, "fx fy cx cy k", None),
    "SIMPLE_FISHEYE": Model(14, "f cx cy", "kannala_brandt"),
    "FISHEYE": Model(15, "fx fy cx cy", "kannala_brandt"),
    "EUCM": Model(16, "fx fy cx cy alpha beta", None),
    "EQUIRECTANGULAR": Model(17, "w h", None),
}
NAMES = {model.number: name for name, model in MODELS.items()}
CONVERTIBLE = [name for name, model in MODELS.items() if model.frame_model]

# The parameters in frames; what COLMAP's model lacks of them is 0.
FRAME_PARAMETERS = {
    "pinhole": "fx fy cx cy",
    "radial_tangential": "fx fy cx cy k1 k2 p1 p2 k3",
    "kannala_brandt": "fx fy cx cy k1 k2 k3 k4",
}


def parameter_count(name):
    return len(MODELS[name].parameters.split())


def frame_camera(camera):
    """(model, parameters) of a camera in frames. Raises InputError if frames have no such projection."""
    model = MODELS.get(camera.model)
    if not model or not model.frame_model:
        raise InputError(f"{camera.place}: expected a camera model that frames have ({', '.join(CONVERTIBLE)}), "
                         f"not {camera.model}")
    names = model.parameters.split()
    if len(names) != len(camera.parameters):
        raise InputError(f"{camera.place}: expected the parameters of {camera.model} ({', '.join(names)}), "
                         f"not {len(camera.parameters)} numbers")
    values = dict(zip(names, camera.parameters, strict=True))
    if "f" in values:
        values["fx"] = values["fy"] = values.pop("f")
    if not values["fx"] > 0 or not values["fy"] > 0:
        raise InputError(f"{camera.place}: expected positive focal lengths")
    wanted = FRAME_PARAMETERS[model.frame_model].split()
    others = [name for name in values if name not in wanted]
    if any(values[name] for name in others):  # the denominator of FULL_OPENCV
        raise InputError(f"{camera.place}: expected {', '.join(others)} of 0 for {camera.model}, because frames have "
                         "no such camera")
    return model.frame_model, [values.get(name, 0.0) for name in wanted]
