# SPDX-License-Identifier: LGPL-2.1-or-later
# Completion of stroma in bash. The command itself knows what may stand where: `stroma __complete WORD...`.

_stroma() {
  # Words of the line up to the cursor, as they were typed: bash also splits at = and :
  local line=${COMP_LINE:0:COMP_POINT} words=() part before i
  for ((i = 0; i <= COMP_CWORD; i++)); do
    part=${COMP_WORDS[i]}
    if ((i == COMP_CWORD)); then
      before=${line%%[![:space:]]*}
      part=${line#"$before"}
    else
      before=${line%%"$part"*}
      line=${line#*"$part"}
    fi
    if [[ -z $before && ${#words[@]} -gt 0 ]]; then
      words[${#words[@]} - 1]+=$part
    else
      words+=("$part")
    fi
  done
  local typed=${words[${#words[@]} - 1]} kept=""
  # bash replaces what stands behind the last = or : of the word
  if [[ $typed == *[=:]* ]]; then kept=${typed%"${typed##*[=:]}"}; fi

  COMPREPLY=()
  local answer kind text
  while IFS= read -r answer; do
    kind=${answer:0:1} text=${answer:1}
    text=${text%%$'\t'*}
    case $kind in
      f) compopt -o filenames 2>/dev/null
         local file
         while IFS= read -r file; do
           if [[ -d $file ]]; then COMPREPLY+=("$file"); continue; fi
           _stroma_fits "${file##*/}" "$text" && COMPREPLY+=("$file")
         done < <(compgen -f -- "${typed#"$kept"}") ;;
      d) compopt -o filenames 2>/dev/null
         while IFS= read -r file; do COMPREPLY+=("$file"); done < <(compgen -d -- "${typed#"$kept"}") ;;
      +) compopt -o nospace 2>/dev/null
         COMPREPLY+=("${text#"$kept"}") ;;
      =) COMPREPLY+=("${text#"$kept"}") ;;
    esac
  done < <("${words[0]}" __complete "${words[@]:1}" 2>/dev/null)
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
