# SPDX-License-Identifier: LGPL-2.1-or-later
# Completion of stroma in fish. The command itself knows what may stand where: `stroma __complete WORD...`.

function __stroma_complete
    set -l words (commandline -opc)
    set -l typed (commandline -ct)
    set -l front (string match -r -- '^--[^=]*=' $typed)
    for answer in ($words[1] __complete $words[2..] "$typed" 2>/dev/null)
        set -l text (string sub -s 2 -- $answer)
        switch (string sub -l 1 -- $answer)
            case f
                set -l patterns (string split ' ' -- (string split -f 1 \t -- $text))
                for file in (__fish_complete_path (string replace -r -- '^--[^=]*=' '' $typed) | string split -f 1 \t)
                    if string match -q -- '*/' $file
                        printf '%s\n' "$front$file"
                        continue
                    end
                    for pattern in $patterns
                        string match -q -- $pattern (string replace -r '.*/' '' $file); and printf '%s\n' "$front$file"; and break
                    end
                end
            case d
                for folder in (__fish_complete_directories (string replace -r -- '^--[^=]*=' '' $typed))
                    printf '%s\n' "$front$folder"
                end
            case '*'
                printf '%s\n' $text
        end
    end
end

complete -c stroma -f -a '(__stroma_complete)'
