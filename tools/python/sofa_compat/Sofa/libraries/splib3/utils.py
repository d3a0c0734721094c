# SPDX-License-Identifier: LGPL-2.1-or-later
"""Old names of arguments."""
import functools


def deprecated_alias(**aliases):
    """Of a function: old="new"."""
    def decorated(function):
        @functools.wraps(function)
        def call(*args, **kwargs):
            return function(*args, **{aliases.get(name, name): value for name, value in kwargs.items()})
        return call
    return decorated
