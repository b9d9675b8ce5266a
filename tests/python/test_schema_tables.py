"""The schema tables of the validator against the official schema files of FMI 2.0 and 3.0, which fmpy brings.

Both are read completely, element by element from the root: names and types of attributes, which of them are required, child elements, their
order and how often they may occur.
"""

from pathlib import Path

import fmpy
import pytest
import xmlschema
from clients.paths import ROOT
from xmlschema.validators import XsdAnyElement, XsdElement

SCHEMAS = Path(fmpy.__file__).parent / "schema"
TABLES = ROOT / "tools" / "archive" / "src" / "validate" / "schema"
MARKS = [("?2", 0, 2), ("?", 0, 1), ("*", 0, None), ("+", 1, None), ("", 1, 1)]
CASES = [
    ("fmi2", "fmi2ModelDescription.xsd", "fmiModelDescription"),
    ("fmi3", "fmi3ModelDescription.xsd", "fmiModelDescription"),
    ("fmi3", "fmi3BuildDescription.xsd", "fmiBuildDescription"),
    ("fmi3", "fmi3TerminalsAndIcons.xsd", "fmiTerminalsAndIcons"),
]
NAMES = {"string": "text", "normalizedString": "text", "anyURI": "text", "nonNegativeInteger": "nonNegative"}


def table(fmi):
    """Words of each definition, groups expanded."""
    definitions = []
    for name in ("common", fmi):
        for line in (TABLES / f"{name}.txt").read_text().splitlines():
            if line and not line.startswith("#"):
                if line.startswith(" "):
                    definitions[-1] += line.split()
                else:
                    definitions.append(line.split())
    groups, elements = {}, {}
    for name, *words in definitions:
        words = [w for word in words for w in groups.get(word, [word])]
        (groups if name.startswith("@") else elements)[name] = words
    return elements


def of_table(words):
    """Attributes and slots of an element of the table."""
    split = words.index(">") if ">" in words else len(words)
    attributes = {}
    for word in words[:split]:
        if word == "anyAttribute":
            attributes[None] = None
        else:
            name, kind = word.split(":", 1)
            attributes[name.rstrip("!")] = (name.endswith("!"), kind)
    slots = []
    for word in words[split + 1 :]:
        mark, least, most = next(m for m in MARKS if word.endswith(m[0]))
        slots.append((word.removesuffix(mark).split("|"), least, most))
    return attributes, slots


def kind_of(simple):
    """A simple type as the table writes it."""
    if simple.is_list():
        return kind_of(simple.item_type) + "*"
    if simple.enumeration:
        return "'" + "|".join(simple.enumeration) + "'"
    if simple.patterns is not None and "XMLSchema}" not in (simple.name or ""):
        assert simple.patterns.regexps == ["3[.](0|[1-9][0-9]*)([.](0|[1-9][0-9]*))?(-.+)?"]
        return "version3"
    while not simple.name or "XMLSchema}" not in simple.name:
        assert not [f for f in simple.facets if f not in simple.base_type.facets], simple
        simple = simple.base_type
    name = simple.name.split("}")[1]
    return NAMES.get(name, name)


def of_schema(element):
    """Attributes and slots of an element of the schema; the children by name."""
    own = element.type
    if own.name and own.name.endswith("}anyType"):
        return {None: None}, [(["any"], 1, 1)], {}
    attributes = {}
    for name, attribute in getattr(own, "attributes", {}).items():
        kind = None if name is None else f"'{attribute.fixed}'" if attribute.fixed else kind_of(attribute.type)
        attributes[name] = None if name is None else (attribute.use == "required", kind)
    slots, children = [], {}

    def group(particles):
        for particle in particles:
            least, most = particle.min_occurs, particle.max_occurs
            if isinstance(particle, XsdAnyElement):
                slots.append((["any1" if most == 1 else "any"], 1, 1))
            elif isinstance(particle, XsdElement):
                children[particle.local_name] = particle
                slots.append(([particle.local_name], least, most))
            elif particle.model == "choice":
                # How often the choice may be made; its alternatives occur once each, or never.
                alternatives = [p for p in particle.iter_elements()]
                assert all(p.max_occurs == 1 for p in alternatives)
                children.update((p.local_name, p) for p in alternatives)
                optional = any(p.min_occurs == 0 for p in alternatives)
                slots.append(([p.local_name for p in alternatives], 0 if optional else least, most))
            elif (least, most) == (1, 1):
                group(particle)
            elif len(particle) == 1 and isinstance(particle[0], XsdElement):
                (one,) = particle
                children[one.local_name] = one
                times = None if most is None or one.max_occurs is None else most * one.max_occurs
                slots.append(([one.local_name], least * one.min_occurs, times))
            else:
                # The interface types of FMI 2: the schema allows four, its text (section 2.2.1) one of each.
                names = [p.local_name for p in particle]
                assert names == ["ModelExchange", "CoSimulation"] and all(p.min_occurs == 0 for p in particle)
                children.update((p.local_name, p) for p in particle)
                slots.append((names, 0, 2))

    if not own.is_simple() and own.content is not None and not own.has_simple_content():
        group([own.content])
    return attributes, slots, children


def normal(slots):
    """Neighbouring slots in comparable form; names without what distinguishes elements of the same name."""
    return [(sorted(n.split(".")[0] for n in names), least, most) for names, least, most in slots]


def compare(element, key, elements, done, path):
    if (element, key) in done:
        return []
    done.add((element, key))
    attributes, slots, children = of_schema(element)
    own_attributes, own_slots = of_table(elements[key])
    found = []
    if attributes != own_attributes:
        found.append(f"{path}: attributes {sorted(set(attributes.items()) ^ set(own_attributes.items()), key=str)}")
    if normal(slots) != normal(own_slots):
        found.append(f"{path}: schema {normal(slots)}, table {normal(own_slots)}")
    for names, _, _ in own_slots:
        for name in names:
            plain = name.split(".")[0]
            if plain in children:
                found += compare(children[plain], name, elements, done, f"{path}/{plain}")
    return found


@pytest.mark.parametrize(("fmi", "file", "root"), CASES)
def test_a_table_has_the_rules_of_the_schema(fmi, file, root):
    schema = xmlschema.XMLSchema(str(SCHEMAS / fmi / file))
    elements, done = table(fmi), set()
    assert compare(schema.elements[root], root, elements, done, root) == []
    assert len(done) > 8


def test_every_change_of_a_table_is_noticed():
    """Each word of the table of FMI 2.0, left out."""
    schema = xmlschema.XMLSchema(str(SCHEMAS / "fmi2" / "fmi2ModelDescription.xsd"))
    root = schema.elements["fmiModelDescription"]
    elements = table("fmi2")
    changes = 0
    for key, words in elements.items():
        for k, word in enumerate(words):
            if word != ">":
                changed = {**elements, key: words[:k] + words[k + 1 :]}
                assert compare(root, "fmiModelDescription", changed, set(), "") != [], (key, word)
                changes += 1
    assert changes > 100
