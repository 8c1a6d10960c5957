"""Lens models as drivers spell them, by the names that `navtool.pipeline.geometry.distortion` knows."""

from typing import NamedTuple

from navtool.pipeline.geometry.distortion import LENS_MODELS, lengths_in_words

_SPELLINGS = {
    "none": ("none", "ideal", "nodistortion", "undistorted", "rectified", "perspective", "pinhole"),
    "plumb_bob": (
        *("plumbbob", "brown", "brownconrady", "modifiedbrownconrady", "radtan", "radialtangential", "radialtangent"),
        *("pinholeradtan", "pinholebrownconrady", "opencv", "opencvpinhole", "standard"),
    ),
    "rational_polynomial": (
        *("rational", "rationalpolynomial", "rationalpolynomial8", "opencv8", "fullopencv", "radtan8"),
        *("thinprism", "thinprismmodel", "rationalpolynomialthinprism", "rationalthinprism", "tilted", "tiltedmodel"),
    ),
    "equidistant": (
        *("equidistant", "equidist", "equi", "fisheye", "opencvfisheye", "fisheyeopencv", "pinholeequi"),
        *("pinholeequidistant", "kannalabrandt", "kannalabrandt4", "kannalabrandtk4", "kb", "kb4"),
    ),
}
"""Without what separates words, in small letters."""
_IDEAL_ALONE = ("inversebrownconrady",)
"""Known with coefficients of 0 alone: RealSense's colour cameras."""
_MODELS = {spelling: model for model, spellings in _SPELLINGS.items() for spelling in spellings}


class Lens(NamedTuple):
    """A lens by a name that is known."""

    model: str
    """none, plumb_bob, rational_polynomial or equidistant."""
    coefficients: tuple[float, ...]
    """As many as the model has; empty for an ideal lens."""
    told: str = ""
    """What was made of a name that says something else than its coefficients; empty where they agree."""


def lens_of(name: str, coefficients: tuple[float, ...]) -> Lens:
    """The lens that a driver describes.

    Zeros behind the coefficients of a model are cut off, as drivers that keep room for more write them. A lens whose
    coefficients are all 0 does not distort, but for fisheye lenses. Without a name OpenCV's model counts, as ROS takes
    it, and so it does where a name means no distortion and the coefficients are not 0.

    Raises:
        ValueError: The name is unknown or the number of coefficients is none that the model has.
    """
    spelling = "".join(letter for letter in name.lower() if letter.isalnum())
    model = _MODELS.get(spelling) if spelling else "none"
    if spelling in _IDEAL_ALONE and not any(coefficients):
        return Lens("none", ())
    if model is None:
        raise ValueError(f"distortion model is '{name}'; known are {', '.join(LENS_MODELS)}")
    if model == "equidistant":
        return Lens(model, _fitting(model, name, coefficients) if coefficients else ())
    if not any(coefficients):
        return Lens(model, coefficients if len(coefficients) in LENS_MODELS[model] else ())
    if model == "none":
        told = f"the distortion model is {name!r} and its coefficients are not 0: plumb_bob is taken"
        return Lens("plumb_bob", _fitting("plumb_bob", name, coefficients), told)
    return Lens(model, _fitting(model, name, coefficients))


def _fitting(model: str, name: str, coefficients: tuple[float, ...]) -> tuple[float, ...]:
    """As many coefficients as the model may have: without zeros at their end, or with as many as it needs."""
    lengths = LENS_MODELS[model]
    if len(coefficients) > lengths[-1] and not any(coefficients[lengths[-1] :]):
        return coefficients[: lengths[-1]]
    if len(coefficients) not in lengths:
        expected = lengths_in_words(model)
        raise ValueError(f"distortion model '{name}' has {len(coefficients)} coefficients; expected {expected}")
    return coefficients
