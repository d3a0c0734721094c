// SPDX-License-Identifier: LGPL-2.1-or-later
// Third-party libraries read files in a separate process: a crash on a damaged file ends that process only, and
// becomes an ordinary error here. Its memory and time are limited by the size of the file.
#pragma once
#include <string>

#include "framework/scene/value_lists.h"

namespace stroma {

/// A program that reads files for this one.
struct ReaderProgram {
  std::string name;     ///< in moduleFolder(), or a path
  std::string reader;   ///< who reads there, for messages: "VTK's reader"
  std::string missing;  ///< why the program may be missing, and what to do
};

/// Runs the program on a file and returns its result. Throws ComponentError with its error, or with how it
/// ended. May be called from any thread; returns when the program ends.
ValueLists readInOwnProcess(const ReaderProgram& program, const std::string& file, const Texts& arguments = {});

// ---- in the program ----

/// `read` gets the file and the arguments; a ComponentError or std::bad_alloc of it reaches the other side.
using ReadFunction = ValueLists (*)(const std::string& file, const Texts& arguments);

/// All of main().
int runReader(int argc, char** argv, ReadFunction read);

/// To be called by `read` when it knows the format: limits memory to `memory_per_byte` bytes per byte of the file, on top
/// of a program's usual memory, and computing time by the file's size.
void limitReader(double file_bytes, double memory_per_byte);

}  // namespace stroma
