# SPDX-License-Identifier: LGPL-2.1-or-later
"""Keys as event["key"] has them."""
A, B, C, D, E, F, G, H, I, J, K, L, M = "ABCDEFGHIJKLM"
N, O, P, Q, R, S, T, U, V, W, X, Y, Z = "NOPQRSTUVWXYZ"
KP_0, KP_1, KP_2, KP_3, KP_4, KP_5, KP_6, KP_7, KP_8, KP_9 = "0123456789"
space = " "
plus, minus, star, slash, dot, comma = "+", "-", "*", "/", ".", ","
escape, tab, backspace, enter, returnKey, insert, delete = "\x00", "\x01", "\x03", "\x04", "\x04", "\x06", "\x07"
leftarrow, uparrow, rightarrow, downarrow = "\x12", "\x13", "\x14", "\x15"
pageup, pagedown, home, end = "\x16", "\x17", "\x10", "\x11"
F1, F2, F3, F4, F5, F6, F7, F8, F9, F10, F11, F12 = (chr(0x130 + number) for number in range(12))

#: keys that a page names in words
NAMED = {"ArrowLeft": leftarrow, "ArrowUp": uparrow, "ArrowRight": rightarrow, "ArrowDown": downarrow, "PageUp": pageup,
         "PageDown": pagedown, "Home": home, "End": end, "Insert": insert, "Enter": enter, "Tab": tab, "Escape": escape,
         "Backspace": backspace, "Delete": delete, "F1": F1, "F2": F2, "F3": F3, "F4": F4, "F5": F5, "F6": F6, "F7": F7, "F8": F8,
         "F9": F9, "F10": F10, "F11": F11, "F12": F12}
