#!/bin/sh
# SPDX-License-Identifier: LGPL-2.1-or-later
# on_huge_pages.sh LIBRARY COMMAND...: runs a compiler with huge_pages.cpp, which is built as LIBRARY. malloc has huge pages of its own.
library=$1
shift
LD_PRELOAD=$library${LD_PRELOAD:+:$LD_PRELOAD} GLIBC_TUNABLES=${GLIBC_TUNABLES:+$GLIBC_TUNABLES:}glibc.malloc.hugetlb=1 exec "$@"
