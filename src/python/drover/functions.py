"""drover/functions.py: Python functions as terms of the equations."""
import inspect
import textwrap

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
            raise Error(f"{name} has the argument {argument}; expected names of fields, such as order_x, and numbers")
        if argument.default is not argument.empty:
            parameters.setdefault(argument.name, argument.default)
    names = [argument.name for argument in arguments]
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
    """{number: TermFunction} of functions for the terms with their names; of equal names in the order of the terms."""
    left, found = list(functions), {}
    for number, term in enumerate(terms, 1):
        same = [one for one in left if name_of(one) == term.get("function")]
        if same:
            found[number] = same[0]
            left.remove(same[0])
    return held_functions(found)
