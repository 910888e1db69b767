"""Parameters: declared with description, type and range; a set that is refused says why."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, Optional

from rcl_interfaces.msg import (
    FloatingPointRange,
    IntegerRange,
    ParameterDescriptor,
    SetParametersResult,
)
from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter

from wholearm_ros.errors import WholeArmError

Service = Callable[[Any, Any], Any]
_KNOWN = {kind.value for kind in Parameter.Type}
_TYPES = {
    bool: Parameter.Type.BOOL,
    int: Parameter.Type.INTEGER,
    float: Parameter.Type.DOUBLE,
    str: Parameter.Type.STRING,
}
_LISTS = {str: Parameter.Type.STRING_ARRAY, float: Parameter.Type.DOUBLE_ARRAY}


class ParameterError(WholeArmError):
    """A parameter given at the start that cannot be used."""


@dataclass(frozen=True)
class Declared:
    """One parameter: its default gives its type, that of a list the first of its items.

    low, high: inclusive, of numbers, also of each in a list; choices: of strings.
    """

    name: str
    default: Any
    description: str
    low: Optional[float] = None
    high: Optional[float] = None
    choices: tuple[str, ...] = ()
    read_only: bool = True

    @property
    def type(self) -> Parameter.Type:
        """As ROS names it."""
        if isinstance(self.default, list):
            return _LISTS[type(self.default[0])]
        return _TYPES[type(self.default)]

    def descriptor(self) -> ParameterDescriptor:
        """As ROS tells it to tools."""
        result = ParameterDescriptor(
            name=self.name, description=self.description, read_only=self.read_only
        )
        if self.choices:
            result.additional_constraints = 'one of: ' + ', '.join(map(str, self.choices))
        numeric = isinstance(self.default, (int, float))  # a list's range ROS cannot tell
        if numeric and self.low is not None and self.high is not None:
            if isinstance(self.default, float):
                result.floating_point_range = [
                    FloatingPointRange(from_value=self.low, to_value=self.high)
                ]
            else:
                result.integer_range = [
                    IntegerRange(from_value=int(self.low), to_value=int(self.high))
                ]
        return result

    def problem(self, value: Any) -> str:
        """Why `value` cannot be used, or nothing. NaN is outside of every range."""
        if self.choices and value not in self.choices:
            return f'{self.name}: got {value!r}; allowed: {", ".join(map(repr, self.choices))}'
        if self.low is None or self.high is None:
            return ''
        numbers = value if isinstance(self.default, list) else [value]
        if not all(self.low <= number <= self.high for number in numbers):
            return f'{self.name}: got {value!r}; allowed: {self.low} to {self.high}'
        return ''


class Parameters:
    """The declared parameters of a node; `values.name` is the value now."""

    def __init__(
        self,
        node: Node,
        declared: Iterable[Declared],
        on_change: Optional[Callable[[], None]] = None,
    ) -> None:
        self._declared = {p.name: p for p in declared}
        self._values: dict[str, Any] = {}
        self._on_change = on_change
        for p in self._declared.values():  # the last of two of one name
            self._values[p.name] = _declare(node, p)
        node.add_on_set_parameters_callback(self._allowed)
        node.add_post_set_parameters_callback(self._store)

    def __getattr__(self, name: str) -> Any:
        try:
            return self.__dict__['_values'][name]
        except KeyError:
            raise AttributeError(name) from None

    def as_dict(self) -> dict[str, Any]:
        """Name → value now."""
        return dict(self._values)

    def _allowed(self, changed: list[Parameter]) -> SetParametersResult:
        for p in changed:
            declared = self._declared.get(p.name)
            if declared is None:
                continue
            wanted = declared.type
            reason = (
                f'{p.name}: got a {p.type_.name}; allowed: {wanted.name}'
                if p.type_ != wanted
                else declared.problem(p.value)
            )
            if reason:
                return SetParametersResult(successful=False, reason=reason)
        return SetParametersResult(successful=True)

    def _store(self, changed: list[Parameter]) -> None:
        known = {p.name: p.value for p in changed if p.name in self._declared}
        self._values.update(known)
        if known and self._on_change:
            self._on_change()


def survives_unknown_types(kind: type, callback: Service) -> Service:
    """`callback` of rclpy's own service for SetParameters or SetParametersAtomically, which a value
    of no known type would end the node with: it is refused instead.
    """

    def guarded(request: Any, response: Any) -> Any:
        wrong = [p for p in request.parameters if p.value.type not in _KNOWN]
        if not wrong:
            return callback(request, response)
        refusal = SetParametersResult(
            successful=False,
            reason=f'{wrong[0].name}: got type {wrong[0].value.type}; '
            f'allowed: {min(_KNOWN)} to {max(_KNOWN)} (rcl_interfaces/msg/ParameterType)',
        )
        if kind is SetParameters:
            response.results = [refusal] * len(request.parameters)
        else:
            response.result = refusal
        return response

    return guarded if kind in (SetParameters, SetParametersAtomically) else callback


def _declare(node: Node, p: Declared) -> Any:
    try:
        value = node.declare_parameter(p.name, p.default, p.descriptor()).value
    except InvalidParameterTypeException as error:
        raise ParameterError(
            f'{node.get_name()}: {p.name}: got the wrong type; '
            f'allowed: {p.type.name} ({p.description})'
        ) from error
    except InvalidParameterValueException as error:
        raise ParameterError(
            f'{node.get_name()}: {p.name}: out of range; allowed: {p.low} to {p.high} '
            f'({p.description})'
        ) from error
    problem = p.problem(value)
    if problem:
        raise ParameterError(f'{node.get_name()}: {problem}')
    return value
