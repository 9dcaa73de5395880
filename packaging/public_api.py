#!/usr/bin/env python3
"""Prints the public interface of a crate, sorted, one item a line: public_api.py FILE, where FILE is what rustdoc writes as JSON.

Names of arguments are left out, because a caller does not see them; paths are shortened to their last segment. Exit code 77 where the
format of the file is not known.
"""
import json
import sys

FIRST_FORMAT, LAST_FORMAT = 53, 60


class Surface:
    def __init__(self, document):
        self.index = document["index"]
        self.lines = set()
        root = self.item(document["root"])
        self.walk_items(root["inner"]["module"]["items"], root["name"])

    def item(self, number):
        return self.index.get(str(number))

    def walk_items(self, numbers, place):
        for number in numbers:
            item = self.item(number)
            if item is not None and item["visibility"] == "public":
                self.add(item, place, item["name"])

    def add(self, item, place, name):
        (kind, inner), = item["inner"].items()
        path = f"{place}::{name}"
        if kind == "use":
            target = None if inner["id"] is None else self.item(inner["id"])
            if target is None or "module" in target["inner"]:
                self.lines.add(f"{marks(item)}pub use {inner['source']} as {place}::{inner['name']}")
            else:
                self.add(target, place, inner["name"])
        elif kind == "module":
            self.lines.add(f"{marks(item)}mod {path}")
            self.walk_items(inner["items"], path)
        elif kind == "function":
            self.lines.add(f"{marks(item)}{function(inner, path)}")
        elif kind in ("struct", "union"):
            self.lines.add(f"{marks(item)}{kind} {path}{generics(inner['generics'])}{shape(inner)}")
            self.add_fields(inner.get("kind"), path)
            self.add_impls(inner["impls"], path)
        elif kind == "enum":
            self.lines.add(f"{marks(item)}enum {path}{generics(inner['generics'])}")
            for number in inner["variants"]:
                variant = self.item(number)
                variant_path = f"{path}::{variant['name']}"
                self.lines.add(f"{marks(variant)}variant {variant_path}")
                self.add_fields(variant["inner"]["variant"]["kind"], variant_path)
            self.add_impls(inner["impls"], path)
        elif kind == "trait":
            self.lines.add(f"{marks(item)}trait {path}{generics(inner['generics'])}{bounds(': ', inner['bounds'])}")
            for number in inner["items"]:
                self.add_member(self.item(number), path, " (required)")
        elif kind in ("constant", "static"):
            self.lines.add(f"{marks(item)}{kind} {path}: {text(inner['type'])}")
        elif kind == "type_alias":
            self.lines.add(f"{marks(item)}type {path}{generics(inner['generics'])} = {text(inner['type'])}")
        else:
            self.lines.add(f"{marks(item)}{kind} {path}")

    def add_fields(self, kind, path):
        """The public fields of a struct, or those of a variant, which are all public."""
        if not isinstance(kind, dict):
            return
        (shape_name, inner), = kind.items()
        numbers = inner if shape_name == "tuple" else inner["fields"]
        for number in numbers:
            field = None if number is None else self.item(number)
            if field is not None:
                self.lines.add(f"{marks(field)}field {path}::{field['name']}: {text(field['inner']['struct_field'])}")

    def add_member(self, item, path, required=""):
        (kind, inner), = item["inner"].items()
        place = f"{path}::{item['name']}"
        if kind == "function":
            self.lines.add(f"{marks(item)}{function(inner, place)}{'' if inner['has_body'] else required}")
        elif kind == "assoc_const":
            self.lines.add(f"{marks(item)}const {place}: {text(inner['type'])}")
        elif kind == "assoc_type":
            self.lines.add(f"{marks(item)}type {place}")

    def add_impls(self, numbers, path):
        for number in numbers:
            item = self.item(number)
            if item is None:
                continue
            inner = item["inner"]["impl"]
            if inner["blanket_impl"] is not None:
                continue
            if inner["trait"] is None:
                for member in map(self.item, inner["items"]):
                    if member["visibility"] == "public":
                        self.add_member(member, path)
            else:
                name = path_text(inner["trait"])
                if name != "StructuralPartialEq":
                    negative = "!" if inner["is_negative"] else ""
                    self.lines.add(f"impl{generics(inner['generics'])} {negative}{name} for {path}")


def marks(item):
    words = [word if isinstance(word, str) else json.dumps(word) for word in item.get("attrs", [])]
    deprecated = "#[deprecated] " if item.get("deprecation") else ""
    must_use = "#[must_use] " if any("must_use" in word for word in words) else ""
    return deprecated + must_use + ("#[non_exhaustive] " if any("non_exhaustive" in word for word in words) else "")


def shape(inner):
    kind = inner.get("kind")
    if kind == "unit":
        return ";"
    (shape_name, fields), = kind.items() if isinstance(kind, dict) else [("plain", {})]
    hidden = None in fields if shape_name == "tuple" else fields.get("has_stripped_fields")
    return " { .. }" if hidden else ""


def function(inner, path):
    header, signature = inner["header"], inner["sig"]
    words = "".join(word + " " for word in ("const", "async", "unsafe") if header[f"is_{word}"])
    output = "" if signature["output"] is None else f" -> {text(signature['output'])}"
    return f"{words}fn {path}{generics(inner['generics'])}({receiver_and_types(signature)}){output}{conditions(inner['generics'])}"


def receiver_and_types(signature):
    return ", ".join("self: " + text(kind) if name == "self" else text(kind) for name, kind in signature["inputs"])


def generics(inner):
    names = []
    for param in inner["params"]:
        (kind, detail), = param["kind"].items()
        if kind == "lifetime":
            names.append(param["name"])
        elif kind == "const":
            names.append(f"const {param['name']}: {text(detail['type'])}")
        elif not detail.get("is_synthetic"):
            names.append(param["name"] + bounds(": ", detail["bounds"]))
    return f"<{', '.join(names)}>" if names else ""


def conditions(inner):
    found = []
    for predicate in inner["where_predicates"]:
        (kind, detail), = predicate.items()
        if kind == "bound_predicate":
            found.append(text(detail["type"]) + bounds(": ", detail["bounds"]))
        else:
            found.append(json.dumps(detail, sort_keys=True))
    return f" where {', '.join(sorted(found))}" if found else ""


def bounds(before, given):
    found = []
    for bound in given:
        (kind, detail), = bound.items()
        if kind == "trait_bound":
            found.append(("?" if detail["modifier"] == "maybe" else "") + path_text(detail["trait"]))
        elif kind == "outlives":
            found.append(detail)
    return before + " + ".join(found) if found else ""


def path_text(path):
    name = (path.get("path") or path.get("name")).rsplit("::", 1)[-1]
    return name + arguments(path.get("args"))


def arguments(given):
    if not isinstance(given, dict):
        return ""
    (kind, inner), = given.items()
    if kind == "parenthesized":
        output = "" if inner["output"] is None else f" -> {text(inner['output'])}"
        return f"({', '.join(map(text, inner['inputs']))}){output}"
    words = []
    for argument in inner["args"]:
        (kind, detail), = argument.items() if isinstance(argument, dict) else [(argument, None)]
        words.append(text(detail) if kind == "type" else detail if kind == "lifetime" else detail["expr"] if kind == "const" else "_")
    for constraint in inner["constraints"]:
        (kind, detail), = constraint["binding"].items()
        value = " = " + text(detail["type"]) if kind == "equality" else bounds(": ", detail)
        words.append(constraint["name"] + value)
    return f"<{', '.join(words)}>" if words else ""


def text(kind):
    if isinstance(kind, str):
        return "_"
    (name, inner), = kind.items()
    if name == "resolved_path":
        return path_text(inner)
    if name in ("generic", "primitive"):
        return inner
    if name == "borrowed_ref":
        lifetime = "" if inner["lifetime"] is None else inner["lifetime"] + " "
        return "&" + lifetime + ("mut " if inner["is_mutable"] else "") + text(inner["type"])
    if name == "tuple":
        return f"({', '.join(map(text, inner))})"
    if name == "slice":
        return f"[{text(inner)}]"
    if name == "array":
        return f"[{text(inner['type'])}; {inner['len']}]"
    if name == "impl_trait":
        return bounds("impl ", inner)
    if name == "dyn_trait":
        lifetime = [] if inner["lifetime"] is None else [inner["lifetime"]]
        return "dyn " + " + ".join([path_text(bound["trait"]) for bound in inner["traits"]] + lifetime)
    if name == "qualified_path":
        trait = inner["trait"]
        of = text(inner["self_type"])
        return f"<{of} as {path_text(trait)}>::{inner['name']}" if trait and path_text(trait) else f"{of}::{inner['name']}"
    if name == "function_pointer":
        signature = inner["sig"]
        output = "" if signature["output"] is None else f" -> {text(signature['output'])}"
        return f"fn({receiver_and_types(signature)}){output}"
    return json.dumps(kind, sort_keys=True)


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        document = json.load(file)
    version = document["format_version"]
    if not FIRST_FORMAT <= version <= LAST_FORMAT:
        print(f"rustdoc writes format {version}, known are {FIRST_FORMAT} to {LAST_FORMAT}", file=sys.stderr)
        sys.exit(77)
    print("\n".join(sorted(Surface(document).lines)))


main()
