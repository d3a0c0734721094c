# SPDX-License-Identifier: LGPL-2.1-or-later
"""What scenes call to tell where they are, and what went wrong."""
import inspect
import os
import sys
import traceback


def formatStackForSofa(stack):
    """Entries of inspect.stack(), a line for each."""
    return "".join(f" in {entry[1]}:{entry[2]}:{entry[3]}()\n" for entry in stack)


def getStackForSofa():
    return formatStackForSofa(inspect.stack()[1:])


def getPythonCallingPoint():
    """(file, line) of who calls."""
    caller = inspect.stack()[1]
    return os.path.abspath(caller[1]), caller[2]


def getPythonCallingPointAsString():
    return formatStackForSofa(inspect.stack()[1:2])


def getSofaFormattedStringFromException(error):
    return repr(error) + "\n" + "".join(traceback.format_tb(error.__traceback__))


def sendMessageFromException(error):
    from .Helper import msg_error

    msg_error("SofaPython3", getSofaFormattedStringFromException(error))


def exceptHandler(kind, error, trace):
    """As sys.excepthook is called."""
    print(f"{kind.__name__}: {error}\n" + "".join(traceback.format_tb(trace)), file=sys.stderr)
