// SPDX-License-Identifier: LGPL-2.1-or-later
// Third-party libraries read files in a separate process: if a damaged file crashes the library, only that process ends,
// and the user gets an ordinary error. Its memory and time are limited by the size of the file.
#pragma once
#include <string>

#include "framework/scene/value_lists.h"

namespace stroma {

/// A program that reads files for this one.
struct ReaderProgram {
  std::string name;     ///< in moduleFolder(), or a path
  std::string reader;   ///< the library, for messages: "VTK's reader"
  std::string missing;  ///< why the program may be missing, and how to get it
};

/// Runs the program on a file and returns its output. Throws ComponentError with its message, or with how it ended. May be
/// called from any thread; returns when the program ends.
ValueLists readInOwnProcess(const ReaderProgram& program, const std::string& file, const Texts& arguments = {});

// ---- in the program ----

/// `read` gets the file and the arguments; its ComponentError or std::bad_alloc is passed to the caller's process.
using ReadFunction = ValueLists (*)(const std::string& file, const Texts& arguments);

/// The body of main().
int runReader(int argc, char** argv, ReadFunction read);

/// Called by `read` once it knows the format: reading may use `memory_per_byte` bytes per byte of the file, in addition
/// to the baseline of a process, and CPU time in proportion to its size.
void limitReader(double file_bytes, double memory_per_byte);

}  // namespace stroma
