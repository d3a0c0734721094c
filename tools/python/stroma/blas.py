# SPDX-License-Identifier: LGPL-2.1-or-later
"""Kernels of OpenBLAS by the instruction set, as modules ask for them (tools/platform/modules.cpp): a processor that is newer than
it is taken for the oldest there is. Where numpy has opened it before, it looks again, so that a run has the bits of `stroma run`."""
import ctypes
import os


def take_kernels(level: str) -> None:
    """What a person has set stays."""
    name = {"x86-64-v4": "SkylakeX", "x86-64-v3": "Haswell"}.get(level)
    if name is None or "OPENBLAS_CORETYPE" in os.environ:
        return
    os.environ["OPENBLAS_CORETYPE"] = name
    try:
        library = ctypes.CDLL("libopenblas.so.0", mode=os.RTLD_NOLOAD | os.RTLD_NOW)
        library.openblas_get_corename.restype = ctypes.c_char_p
        if library.openblas_get_corename().decode() != name:
            library.gotoblas_dynamic_quit()
            library.gotoblas_dynamic_init()
    except (OSError, AttributeError):  # nobody has opened it, or it was built for one kind of processor
        pass
