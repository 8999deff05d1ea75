"""Contact algorithms: every registered one, ours and third parties', by its class name."""

from mpmkit._core.namespace import namespace

__getattr__, __dir__ = namespace(__name__, "contact")
