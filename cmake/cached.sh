#!/bin/sh
# SPDX-License-Identifier: LGPL-2.1-or-later
# cached.sh CCACHE COMPILER ARGUMENTS...: compiles through ccache, which has to be told how to know precompiled headers again.
# A precompiled header knows the files in it by their content. ccache must compare files there (CCACHE_DEPEND), and not what the
# preprocessor makes of them: one from before a change of a comment would have the compiler read the changed file twice. All
# else goes through the preprocessor, where ccache sees the files that an assembler's .incbin takes and leaves those alone.
case " $* " in
  *" c++-header "*) export CCACHE_DEPEND=true ;;
esac
CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime exec "$@"
