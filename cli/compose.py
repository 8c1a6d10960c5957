"""From a YAML file, a schema and ``key=value`` overrides to a typed configuration."""

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import fields, is_dataclass

from navtool.base.errors import NavtoolError
from navtool.base.setting_error import SettingError

_CURE = "the command's `--cfg job` prints every key with its value"
_BY_NAME = re.compile(
    r"(sync\.cameras|sync\.lidars|robot\.cameras|robot\.lidars|robot\.mounting)(?:\.([\w.]+))?=(.*)", re.S
)
"""Settings below a name that a user chooses, which Hydra only adds as a whole table."""
_CURE_STRAY = "set settings with KEY=VALUE; folders and files are named with options, see the command's `--help`"


class UsageError(NavtoolError):
    """The command was not called rightly; exit code 2."""


class ChoiceError(UsageError):
    """A setting that takes one of a few values was given another one."""

    def __init__(self, key: str, value: object, choices: Sequence[str]) -> None:
        self.key, self.choices = key, tuple(choices)
        cure = f"use {key}={' or '.join(choices)}" if choices else _CURE
        super().__init__(f"there is no such value as {value}", where=f"{key}={value}", cure=cure)
        self.value = value


def compose[T](config: str, overrides: Sequence[str], result: type[T]) -> T:
    """The configuration that an override list gives.

    Raises:
        SettingError: If an override gives a value out of range.
        UsageError: If an override is malformed, or names an unknown key.
    """
    from hydra import compose as hydra_compose
    from hydra import initialize_config_dir
    from hydra.core.global_hydra import GlobalHydra

    from navtool.configs.schema import config_folder, register

    if added := [override for override in overrides if override.startswith("+")]:
        raise UsageError(f"{', '.join(added)}: there is no such setting to add", cure=_CURE)
    if stray := [override for override in overrides if "=" not in override and not override.startswith("~")]:
        raise UsageError(f"{', '.join(stray)}: not of the form KEY=VALUE", cure=_CURE_STRAY)
    merged = [_by_name(override) for override in overrides]
    register(config)
    GlobalHydra.instance().clear()
    try:
        with usage_errors(config), initialize_config_dir(str(config_folder()), version_base="1.3"):
            return to_typed(hydra_compose(config, merged), result)
    except ChoiceError as error:
        # A type's values are not all for every setting of that type: each is tried.
        others = [override for override in overrides if override.partition("=")[0].lstrip("+") != error.key]
        fit = [choice for choice in error.choices if _fits(config, [*others, f"{error.key}={choice}"], result)]
        raise ChoiceError(error.key, error.value, fit or error.choices) from error
    except UsageError as error:
        what = error.what
        for new, typed in zip(merged, overrides, strict=True):
            what = what.replace(new, typed)
        raise UsageError(what, where=error.where, cure=error.cure) from error


def _by_name(override: str) -> str:
    """A setting such as ``sync.cameras.rear.tolerance_s=0.1`` as the table ``{rear: {tolerance_s: 0.1}}`` to merge."""
    named = _BY_NAME.fullmatch(override)
    if named is None:
        return override
    group, keys, value = named.groups()
    for key in reversed(keys.split(".") if keys else []):
        value = f"{{{key}: {value}}}"
    return f"++{group}={value}"


def _fits(config: str, overrides: Sequence[str], result: type) -> bool:
    """Whether a configuration composes; another one of its overrides may be what is wrong with it."""
    try:
        compose(config, overrides, result)
    except (SettingError, UsageError):
        return False
    return True


def refuse_unknown(group: str, name: str, what: str) -> None:
    """Refuse the name of an option that a group of configurations does not have.

    Raises:
        UsageError: There is none; those that there are, are listed.
    """
    from navtool.configs.schema import config_folder

    known = sorted(path.stem for path in (config_folder() / group).glob("*.yaml"))
    if name not in known:
        raise _unknown_option(name, known, what)


def _unknown_option(name: str, known: Sequence[str], what: str) -> UsageError:
    from difflib import get_close_matches

    near = get_close_matches(name, known, 1)
    meant = f" (did you mean {near[0]}?)" if near else ""
    return UsageError(f"no {what} is called {name!r}{meant}", cure=f"known are {', '.join(known)}")


def refuse_unknown_choices(group: str, overrides: Sequence[str], what: str) -> None:
    """Refuse overrides such as ``sensor=vlp17`` that choose from a group what it does not have.

    Raises:
        UsageError: As `refuse_unknown`.
    """
    for override in overrides:
        if override.startswith(f"{group}="):
            refuse_unknown(group, override.removeprefix(f"{group}="), what)


def to_typed[T](composed: object, result: type[T]) -> T:
    """A composed configuration as the dataclass behind it, whose own checks run now.

    Raises:
        SettingError: If values are out of range.
        UsageError: If a value is missing, or of another type.
    """
    from omegaconf import OmegaConf

    from navtool.cli.faulty_setting import refused_settings

    try:
        with usage_errors():
            typed = OmegaConf.to_object(composed)
    except SettingError as error:
        # What OmegaConf builds does not know what it is a part of.
        raise SettingError(*(refused_settings(composed) or error.faults), cure=_CURE) from error
    if not isinstance(typed, result):
        raise TypeError(f"composed {type(typed).__name__} instead of {result.__name__}")
    return typed


@contextmanager
def usage_errors(config: str | None = None) -> Iterator[None]:
    """Turn what Hydra and OmegaConf raise about a configuration into one readable message.

    Args:
        config: The name of the configuration, whose nearest key is told in the place of one that there is not.
    """
    from hydra.errors import HydraException, MissingConfigException
    from omegaconf.errors import OmegaConfBaseException

    try:
        yield
    except (HydraException, OmegaConfBaseException) as error:
        if (refused := _refused_choice(error)) is not None:
            raise refused from error
        if isinstance(error, MissingConfigException) and error.options:
            group, _, name = str(error.missing_cfg_file).rpartition("/")
            options = sorted(option for option in error.options if not option.endswith("_schema"))
            raise _unknown_option(name, options, group) from error
        raise (_unknown_key(error, config) or _unquoted(error) or UsageError(_readable(error), cure=_CURE)) from error
    except AssertionError as error:
        if not str(error).startswith("Unexpected type for root: NoneType"):
            raise
        # what OmegaConf says of a key below a group that is null, as robot.joy is where there is no joystick
        cure = "write the whole group into a robot file, and pass it with --robot"
        raise UsageError("an override sets a key of a group that is not there", cure=cure) from error


def _unknown_key(error: BaseException | None, config: str | None) -> UsageError | None:
    """What is said where a key does not exist: the one that was meant, if any is near."""
    from omegaconf.errors import ConfigAttributeError, ConfigKeyError

    from navtool.base.from_plain import did_you_mean

    while error is not None and not isinstance(error, ConfigAttributeError | ConfigKeyError):
        error = error.__cause__
    if error is None or not error.full_key:
        return None
    key = str(error.full_key)
    beside = [field.name for field in fields(error.object_type)] if is_dataclass(error.object_type) else []
    hint = did_you_mean(str(error.key), beside)
    if not hint and config is not None:
        known, last = list(_known_keys(config)), key.rpartition(".")[2]
        alike = sorted((other for other in known if other.rpartition(".")[2] == last), key=len)
        hint = f" (did you mean {alike[0]!r}?)" if alike else did_you_mean(key, known)
    return UsageError(f"there is no setting {key}{hint}", cure=_CURE)


def _known_keys(config: str) -> Iterator[str]:
    """The dotted keys of a configuration as it is without overrides."""
    from hydra import compose as hydra_compose
    from hydra import initialize_config_dir
    from hydra.core.global_hydra import GlobalHydra
    from omegaconf import OmegaConf

    from navtool.base.plain import flatten
    from navtool.configs.schema import config_folder

    GlobalHydra.instance().clear()
    with initialize_config_dir(str(config_folder()), version_base="1.3"):
        yield from flatten(OmegaConf.to_container(hydra_compose(config)))


def _unquoted(error: BaseException) -> UsageError | None:
    """What is said where an override cannot be read for want of quotes."""
    override = getattr(error, "override", None)
    key, _, value = str(override or "").partition("=")
    if not any(sign in value for sign in "{}()[],: ") or value[:1] in "'\"":
        return None
    what = "the value holds signs with a meaning of their own"
    return UsageError(
        what, where=override, cure=f"""put it in quotes, and these in others for the shell: "{key}='{value}'\""""
    )


def _refused_choice(error: BaseException | None) -> ChoiceError | None:
    """What is said where a value is none of an enum's."""
    from omegaconf import EnumNode
    from omegaconf.errors import ValidationError

    while error is not None:
        if isinstance(error, ValidationError) and isinstance(error.child_node, EnumNode):
            return ChoiceError(str(error.full_key), error.value, list(error.child_node.enum_type.__members__))
        error = error.__cause__
    return None


@contextmanager
def wrong_call() -> Iterator[None]:
    """What navtool refuses within was called wrongly: a setting, or an output that is something else already."""
    try:
        yield
    except (SettingError, UsageError):
        raise
    except NavtoolError as error:
        raise UsageError(error.what, where=error.where, cure=error.cure) from error


def _readable(error: BaseException) -> str:
    """The innermost message that says something, on one line."""
    messages = [f"override {error.override!r}"] if hasattr(error, "override") else []
    current: BaseException | None = error
    while current is not None:
        text = " ".join(line.strip() for line in str(current).splitlines() if _says_something(line))
        text = text.partition(" Config search path:")[0]
        if text and text not in messages:
            messages.append(text)
        current = current.__cause__
    return messages[0] if len(messages) == 1 else f"{messages[0]} ({messages[-1]})"


def _says_something(line: str) -> bool:
    noise = (
        "To append to your config use",
        "To append to your default list use",
        "full_key:",
        "reference_type=",
        "object_type=",
        "See https://",
        "Set the environment variable",
    )
    return bool(line.strip()) and not line.strip().startswith(noise)


def print_config(config: object, part: str) -> None:
    """Print a composed configuration as YAML, as Hydra's own ``--cfg job`` does.

    Raises:
        UsageError: The part is not ``job``.
    """
    import yaml

    from navtool.base.plain import plain
    from navtool.cli.console import console

    if part != "job":
        raise UsageError(f"--cfg {part}: there is only the job's configuration", cure="use --cfg job")
    text = yaml.safe_dump(plain(config), sort_keys=False, allow_unicode=True, width=120)
    console().print(text, markup=False, highlight=False, soft_wrap=True, end="")


def quoted(value: object) -> str:
    """A value as an override's right-hand side: Hydra takes it literally."""
    # In Hydra's quotes a backslash counts only before a quote.
    text = re.sub(r"(\\*)('|$)", lambda found: found[1] * 2 + ("\\'" if found[2] else ""), str(value))
    return f"'{text}'"
