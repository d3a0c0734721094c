# SPDX-License-Identifier: LGPL-2.1-or-later
# Completion of stroma in bash. The command itself knows what may stand where: `stroma __complete WORD...`.
# Nothing of the line or of a scene is ever evaluated.

_stroma() {
  local words=() typed="" front="" quote="" tilde=""
  local -i kept=0
  _stroma_read "${COMP_LINE:0:COMP_POINT}" "${2-}"
  typed=${words[${#words[@]} - 1]}
  if [[ $typed == --*=* ]]; then front=${typed%%=*}=; fi

  COMPREPLY=()
  local answer kind text plain
  while IFS= read -r answer; do
    kind=${answer:0:1} text=${answer:1}
    text=${text%%$'\t'*}
    case $kind in
      f | d) compopt -o filenames 2>/dev/null
         _stroma_files "$kind" "$text" ;;
      + | =)
         printf -v plain %q "$text"
         # a candidate that needs quotes is not offered inside of some
         if [[ -n $quote && $plain != "$text" ]]; then continue; fi
         if [[ $kind == + ]]; then compopt -o nospace 2>/dev/null; fi
         printf -v plain %q "${text:kept}"
         COMPREPLY+=("$plain") ;;
    esac
  done < <("${words[0]}" __complete "${words[@]:1}" 2>/dev/null)
}

# LINE TEXT: the words of the line without their quotes, and in `kept` how much of the last one stands before TEXT, which
# bash replaces. ~ and variables are looked up; commands stay as they were typed.
_stroma_read() {
  local line=$1 word="" letter is_word=""
  local -i i from=$((${#1} - ${#2}))
  if [[ ${line:from} != "$2" ]]; then from=${#line}; fi
  for ((i = 0; i < ${#line}; i++)); do
    if ((i == from)); then kept=${#word}; fi
    letter=${line:i:1}
    if [[ $quote == "'" ]]; then
      if [[ $letter == "'" ]]; then quote=""; else word+=$letter; fi
    elif [[ $letter == "$quote" ]]; then
      quote=""
    elif [[ $letter == \\ && ( -z $quote || ${line:i+1:1} == [\$\`\"\\] ) ]]; then
      i+=1 is_word=1
      word+=${line:i:1}
    elif [[ $letter == \$ && ${line:i+1} =~ ^([A-Za-z_][A-Za-z0-9_]*|\{[A-Za-z_][A-Za-z0-9_]*\}) ]]; then
      i+=${#BASH_REMATCH[0]} is_word=1
      letter=${BASH_REMATCH[0]//[\{\}]/}
      word+=${!letter-}
    elif [[ -n $quote ]]; then
      word+=$letter
    elif [[ $letter == [\'\"] ]]; then
      quote=$letter is_word=1
    elif [[ $letter == [[:space:]] ]]; then
      if [[ -n $is_word ]]; then words+=("$word"); fi
      word="" is_word="" tilde=""
    elif [[ $letter == \~ && -z $is_word && ${line:i+1:1} == / ]]; then
      word=$HOME is_word=1 tilde=1
    else
      word+=$letter is_word=1
    fi
  done
  if ((i == from)); then kept=${#word}; fi
  words+=("$word")
}

# KIND PATTERNS: files that fit, and folders
_stroma_files() {
  local file
  while IFS= read -r file; do
    if [[ $1 == f && ! -d $file ]]; then _stroma_fits "${file##*/}" "$2" || continue; fi
    file=$front$file
    if [[ -n $tilde ]]; then file=\~${file#"$HOME"}; fi
    COMPREPLY+=("${file:kept}")
  done < <(compgen "-$1" -- "${typed#"$front"}")
}

# NAME PATTERNS: whether a pattern fits
_stroma_fits() {
  local IFS=' ' pattern patterns
  read -ra patterns <<<"$2"
  for pattern in "${patterns[@]}"; do
    # shellcheck disable=SC2053
    [[ $1 == $pattern ]] && return 0
  done
  return 1
}

complete -F _stroma stroma
