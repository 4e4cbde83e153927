"""Writes the type stub of the package surfit from its docstrings: write_stub.py FILE

pybind11 puts the signature of each function and property in the first lines of its docstring.
"""

import inspect
import re
import sys

import surfit

HEADER = '''"""Types of the package surfit; written by write_stub.py when it is built."""

from os import PathLike
from typing import Any, Callable, Dict, List, Optional, Tuple, Union, overload

import numpy
from numpy.typing import ArrayLike, NDArray

__version__: str
'''


def typed(text):
    """pybind11's names of types as Python's."""
    text = re.sub(r"\b(float)\[\d+\]", r"\1", text)  # std::array
    text = re.sub(r"numpy\.ndarray\[(numpy\.\w+)(\[[^\]]*\])?[^\]]*\]", r"NDArray[\1]", text)
    text = re.sub(r"(\w+): numpy\.ndarray\b(?!\[)", r"\1: ArrayLike", text)
    text = re.sub(r"(\w+): NDArray\[numpy\.\w+\]", r"\1: ArrayLike", text)
    text = re.sub(r"(\w+): Optional\[NDArray\[numpy\.\w+\]\]", r"\1: Optional[ArrayLike]", text)
    text = text.replace("numpy.ndarray", "NDArray[Any]")
    text = re.sub(r"\bos\.PathLike\b", "Union[str, PathLike[str]]", text)
    text = re.sub(r"\bsurfit\.", "", text)
    text = re.sub(r"\bobject\b", "Any", text)
    text = re.sub(r"= <[^>]*>|= \w+\(.*?\)(?=, \w+:|, \*|\) ->)", "= ...", text)
    return re.sub(r"\*\*kwargs", "**kwargs: Any", re.sub(r"\*args", "*args: Any", text))


def overloads(function, name):
    """(signature, text) of each overload."""
    lines = (function.__doc__ or "").strip().split("\n")
    if "Overloaded function." not in lines:
        yield lines[0], "\n".join(lines[1:]).strip()
        return
    text = "\n".join(lines)
    pattern = rf"^\d+\. ({name}\(.*\) -> .*)\n((?:.*\n?)*?)(?=^\d+\. {name}\(|\Z)"
    for match in re.finditer(pattern, text, re.MULTILINE):
        yield match.group(1), match.group(2).strip()


def docstring(text, indent):
    return f'{indent}"""{text}"""\n' if text else f"{indent}...\n"


def function_stub(function, name, indent):
    found = list(overloads(function, name))
    text = ""
    for signature, doc in found:
        text += f"{indent}@overload\n" if len(found) > 1 else ""
        signature = re.sub(r"\(self: [\w.]+", "(self", typed(signature))
        text += f"{indent}def {signature}:\n" + docstring(doc, indent + "    ")
    return text


def value_type(member):
    """The type that a property takes."""
    value = re.match(r"\(.*arg\d: (.*)\) -> None", member.fset.__doc__.strip()).group(1)
    return typed(f"value: {value}").removeprefix("value: ")


def property_stub(member, name):
    returned = (member.fget.__doc__ or "-> Any").strip().split("\n")[0].split("-> ")[-1]
    stub = f"    @property\n    def {name}(self) -> {typed(returned)}:\n"
    stub += docstring(member.__doc__, "        ")
    if member.fset:
        stub += f"    @{name}.setter\n"
        stub += f"    def {name}(self, value: {value_type(member)}) -> None: ...\n"
    return stub


def keyword_init_stub(cls, init):
    """Of options: their keywords are the properties."""
    keywords = [f"{name}: {value_type(member)} = ..." for name, member in vars(cls).items()
                if isinstance(member, property)]
    doc = init.__doc__.strip().split("\n")[-1]
    return f"    def __init__(self, *, {', '.join(keywords)}) -> None:\n" + docstring(doc, " " * 8)


def class_stub(cls):
    text = f"\nclass {cls.__name__}:\n" + docstring(cls.__doc__, "    ")
    for name, member in vars(cls).items():
        if isinstance(member, property):
            text += property_stub(member, name)
        elif not inspect.isroutine(member) or not re.search(rf"\b{name}\(", member.__doc__ or ""):
            continue  # not by pybind11
        elif re.match(r"__init__\(self: [\w.]+, \*\*kwargs\)", member.__doc__):
            text += keyword_init_stub(cls, member)
        else:
            text += function_stub(member, name, "    ")
    return text


def module_stub():
    text = HEADER
    for name in surfit.__all__:
        member = getattr(surfit, name)
        if inspect.isclass(member):
            text += class_stub(member)
        else:
            text += "\n" + function_stub(member, name, "")
    return text


with open(sys.argv[1], "w", encoding="utf-8") as file:
    file.write(module_stub())
