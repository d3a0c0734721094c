#!/bin/sh
# SPDX-License-Identifier: LGPL-2.1-or-later
# with_clang.sh COMPILER CLANG [CACHE...] COMPILER ARGUMENTS...: compiles with CLANG in the place of the project's compiler (GCC), whose
# options it knows but for a few. What precompiled headers instantiate is compiled with them, once; they know their files by size and
# not by time, because a cache gives them back for equal files. The one from before a change goes first: clang would take it into the
# new one. What has -DSTROMA_BY_GCC is left to the project's compiler.
compiler=$1 clang=$2 before='' output='' is_header=no
shift 2
case " $* " in
  *" -DSTROMA_BY_GCC "*) exec "$@" ;;
esac
for word; do
  shift
  case $word in
    "$compiler") word=$clang ;;
    -fpch-preprocess | --param=*) continue ;;
    c++-header) set -- "$@" c++-header -fpch-instantiate-templates -Xclang; word=-fno-pch-timestamp is_header=yes ;;
  esac
  [ "$before" = -o ] && output=$word
  before=$word
  set -- "$@" "$word"
done
[ $is_header = yes ] && rm -f "$output"
exec "$@"
