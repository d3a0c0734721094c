// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

/// Counts the instructions of one step by their places, where STROMA_COUNT in the environment names a file for them: lines
/// "count offset library". Called once, before the first step.
void countInstructionsOfAStep();
