"""Tests that every setting of softcd::bullet::Settings can be given in PyBullet, and is read as it was given."""

import enum
import json
import pathlib
import re
import typing

import pytest

from bullet_worlds import pybullet
import softcd
import softcd._bullet_plugin
import softcd.bullet


ROOT = pathlib.Path(__file__).resolve().parents[2]

# How the members of C++ are named in Python, where their names differ. None: what Python has no use for.
OTHER_NAMES = {
    "body_contacts": "contacts",
    "contact_report": "report",
    "convex_shape_report": "report",
    "crossing_answers": "report",
    "crossing_report": "report",
    "forget_ray_positions": None,  # PyBullet's own ray tests are not replaced
    "rigid_mesh_report": "report",
}


@pytest.fixture
def client():
    client = pybullet.connect(pybullet.DIRECT)
    yield client
    pybullet.disconnect(client)


@pytest.fixture
def schema(client):
    """All settings that C++ lists, by keyword, with their words and their values in each preset."""
    return json.loads(softcd._bullet_plugin.Plugin(client).text("all_settings"))


def words_and_enumeration(annotation):
    """Returns the words of a setting's type, and its class for them."""
    parts = typing.get_args(annotation) or (annotation,)
    words = [word for part in parts if typing.get_origin(part) is typing.Literal for word in typing.get_args(part)]
    enumerations = [part for part in parts if isinstance(part, type) and issubclass(part, enum.Enum)]
    return words, (enumerations or [None])[0]


def in_the_soft_world(name, value):
    """Returns the value that a soft world's settings have where this one was given."""
    return "off" if (name, value) == ("edge_contacts", "automatic") else value


def test_python_has_the_settings_and_words_of_cpp(schema):
    annotations = typing.get_type_hints(softcd.bullet.Settings)
    assert list(annotations) == list(schema) and len(schema) >= 16
    for name, setting in schema.items():
        words, enumeration = words_and_enumeration(annotations[name])
        assert words == setting.get("values", []), name
        if words:
            assert [value.name for value in enumeration] == words, name
        else:
            assert type(setting["balanced"]) in (bool, int, float) and enumeration is None, name
    for preset in typing.get_args(softcd.bullet.Preset):
        assert all(preset in setting for setting in schema.values())


def functions(header, name):
    """Returns the names of a C++ class's public functions."""
    text = (ROOT / "bullet_integration" / "include" / "softcd" / "bullet" / header).read_text()
    body = re.search(rf"^class SOFTCD_EXPORT {name} {{\n(.*?)^ private:", text, re.MULTILINE | re.DOTALL)[1]
    return set(re.findall(r"^  [\w:<>*& ]*[\w>&*] [&*]?(\w+)\([^)]*\)(?: const)?;", body, re.MULTILINE)) - {name}


def test_python_has_the_functions_of_cpp():
    found = functions("world_detection.hpp", "WorldDetection")
    assert {"intersecting_bodies", "edge_contacts", "settings", "set_filters", "body_contacts"} <= found and len(found) >= 12
    for function in found | functions("attach.hpp", "Attachment") - {"detection"}:
        name = OTHER_NAMES.get(function, function)
        assert name is None or hasattr(softcd.bullet.Attachment, name), f"Attachment lacks {function}"


def test_every_setting_is_read_as_it_was_given(client, schema):
    annotations = typing.get_type_hints(softcd.bullet.Settings)
    for name, setting in schema.items():
        default = setting["balanced"]
        if "values" in setting:
            enumeration = words_and_enumeration(annotations[name])[1]
            words = [word for word in setting["values"] if word != "cuda"]
            values = [(word, word) for word in words] + [(enumeration[word], word) for word in words]
        elif isinstance(default, bool):
            values = [(False, False), (True, True)]
        else:
            values = [(2, 2), (3, 3)]
        for given, expected in values:
            with softcd.bullet.attach(client, **{name: given}) as attachment:
                settings = attachment.settings
            assert settings[name] == in_the_soft_world(name, expected) and type(settings[name]) is type(default)
            others = {other: in_the_soft_world(other, schema[other]["balanced"]) for other in schema if other != name}
            assert {other: settings[other] for other in others} == others


@pytest.mark.parametrize("preset", typing.get_args(softcd.bullet.Preset))
def test_presets_are_those_of_cpp(client, schema, preset):
    expected = {name: in_the_soft_world(name, setting[preset]) for name, setting in schema.items()}
    with softcd.bullet.attach(client, preset=preset) as attachment:
        assert attachment.settings == expected
    with softcd.bullet.attach(client, preset=preset, contacts_per_node=4) as attachment:
        assert attachment.settings == expected | {"contacts_per_node": 4}


def test_presets_differ(schema):
    values = [tuple(setting[preset] for setting in schema.values()) for preset in ("fast", "balanced", "safe")]
    assert len(set(values)) == 3


def test_settings_change_while_attached(client):
    with softcd.bullet.attach(client, preset="safe", read_out="contacts") as attachment:
        before = attachment.settings
        attachment.set_settings(edge_contacts="report", cell_size_factor=2.5)
        assert attachment.settings == before | {"edge_contacts": "report", "cell_size_factor": 2.5}
        attachment.set_settings(preset="balanced", read_out=softcd.bullet.ReadOut.impulses)
        changed = attachment.settings
        assert changed["detection"] == "dcd" and changed["read_out"] == "impulses" and changed["cell_size_factor"] == 0
        with pytest.raises(softcd.InvalidInput, match="cell_size_factor is 1000"):
            attachment.set_settings(detection="ccd", cell_size_factor=1000)
        assert attachment.settings == changed
    with pytest.raises(softcd.Error, match="not attached"):
        attachment.set_settings(detection="ccd")


@pytest.mark.parametrize(
    "settings, error, text",
    [
        ({"detectoin": "ccd"}, softcd.InvalidInput, "detectoin: there is no such setting; did you mean 'detection'"),
        ({"speed": 3}, softcd.InvalidInput, "speed: there is no such setting; there are preset, backend, detection"),
        ({"presett": "safe"}, softcd.InvalidInput, "presett: there is no such setting; did you mean 'preset'"),
        ({"detection": "often"}, softcd.InvalidInput, "detection: 'often' is none of dcd, ccd"),
        ({"detection": softcd.bullet.ReadOut.off}, softcd.InvalidInput, "detection: 'off' is none of dcd, ccd"),
        ({"detection": None}, TypeError, "detection: expected a name, an enumerator, True, False or a number, got Non"),
        ({"detection": "ccd reuse_pairs=False"}, softcd.InvalidInput, "detection: 'ccd reuse_pairs=False' is no value"),
        ({"detection": ""}, softcd.InvalidInput, "detection: '' is no value"),
        ({"rigid_meshes": 1}, softcd.InvalidInput, "rigid_meshes: '1' is none of False, True"),
        ({"contacts_per_node": 1.5}, softcd.InvalidInput, "contacts_per_node: '1.5' is no count"),
        ({"cell_size_factor": float("nan")}, softcd.InvalidInput, "cell_size_factor"),
        ({"preset": "best"}, softcd.InvalidInput, "preset: 'best' is none of fast, balanced, safe"),
        ({"preset": 1}, softcd.InvalidInput, "preset: '1' is none of fast, balanced, safe"),
        ({"log": print}, softcd.InvalidInput, "log: .* read Attachment.messages"),
        ({"on_contacts": print}, softcd.InvalidInput, "on_contacts: .* read Attachment.contacts"),
        ({"on_error": "throw_error"}, softcd.InvalidInput, "on_error: in PyBullet .* read failed_steps"),
        ({"backend": "x" * 2000}, softcd.InvalidInput, "has 20.. characters"),
    ],
)
def test_errors_name_the_setting_and_what_is_wanted(client, settings, error, text):
    with pytest.raises(error, match=text):
        softcd.bullet.attach(client, **settings)
    with softcd.bullet.attach(client):
        pass


def test_a_backend_that_is_not_there_has_its_own_exception(client):
    try:
        softcd.Scene(backend="cuda")
    except softcd.BackendError:
        with pytest.raises(softcd.BackendError):
            softcd.bullet.attach(client, backend="cuda")
