"""drover/functions.py: Python functions as terms of the equations."""
import ast
import inspect
import textwrap
import warnings

from drover import _drover
from drover.error import Error


def name_of(function):
    return getattr(function, "__name__", type(function).__name__)


def function_table(of, function, parameters):
    """The entry of [[terms]] for a function: name, arguments, source; defaults that are numbers become parameters."""
    name = name_of(function)
    try:
        arguments = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        raise Error(f"the arguments of {name} cannot be read; expected a Python function: lambda order_x, order_y: "
                    f"{name}(...)") from None
    for argument in arguments:
        if argument.kind not in (argument.POSITIONAL_ONLY, argument.POSITIONAL_OR_KEYWORD):
            raise Error(f"{name} has the {argument.kind.description} argument {argument}; expected names of fields, "
                        "such as order_x, and numbers, without *")
        if argument.default is not argument.empty:
            parameters.setdefault(argument.name, argument.default)
    names = [argument.name for argument in arguments]
    if not names:
        raise Error(f"{name} has no arguments; expected at least one, such as order_x")
    for parameter in parameters:
        if parameter not in names:
            raise Error(f"{name} has no argument {parameter}; expected one of {', '.join(names)}")
    return {"of": of, "function": name, "arguments": names, "source": source_of(function)}


def source_of(function):
    """Its text, if there is one."""
    try:
        return textwrap.dedent(inspect.getsource(function))
    except (OSError, TypeError):
        return ""


def function_of(of, value, flux):
    """Which of value and flux is a function, if one is: a density has a flux, a vector a value."""
    if not callable(value) and not callable(flux):
        return None
    if value is not None and flux is not None:
        raise Error("value and flux are both given; expected one of them")
    from drover.fields import shipped_fields
    is_density = of in (field.name for field in shipped_fields() if field.conserved)
    if is_density != callable(flux):
        raise Error(f"the term of {of} is a function given as {'value' if is_density else 'flux'}; expected "
                    f"{'flux=, whose x and y components it returns' if is_density else 'a function as value'}")
    return flux if is_density else value


def held_functions(functions):
    """{number of a term: TermFunction}; scenes that follow from one share the lock of each."""
    return {number: one if isinstance(one, _drover.TermFunction) else _drover.TermFunction(one)
            for number, one in functions.items()}


def functions_by_number(terms, functions):
    """{number: TermFunction} of functions for the terms with their names; of equal names in the order of the terms.

    Raises Error for a function with other arguments than the term has, and warns of one with another text.
    """
    left, found = list(functions), {}
    for number, term in enumerate(terms, 1):
        same = [one for one in left if name_of(one) == term.get("function")]
        if same:
            require_same(same[0], term)
            found[number] = same[0]
            left.remove(same[0])
    if left:
        raise Error(f"{name_of(left[0])} is not a function of this run; expected those of its terms: "
                    + (", ".join(term["function"] for term in terms if "function" in term) or "it has none"))
    return held_functions(found)


def require_same(function, term):
    """The text of a lambda is that of the line where it is written, and says nothing."""
    name, recorded = name_of(function), term.get("source", "")
    arguments = [*inspect.signature(function).parameters]
    if arguments != term["arguments"]:
        raise Error(f"{name} has the arguments {', '.join(arguments)}; expected those of the run, "
                    + ", ".join(term["arguments"]))
    given = source_of(function)
    if name != "<lambda>" and recorded and given and code_of(given) != code_of(recorded):
        warnings.warn(f"{name} is not the function with which the run began, whose text is in the archive: "
                      "archive.scene[\"terms\"]; from here on the run has other equations", stacklevel=4)


def code_of(source):
    """Its syntax tree, whatever its comments and layout; the text itself where that is not whole."""
    try:
        return ast.dump(ast.parse(source))
    except SyntaxError:
        return source
