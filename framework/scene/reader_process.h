// SPDX-License-Identifier: LGPL-2.1-or-later
// Files that are read by libraries of others are read in a process of their own: a fault that a damaged file finds there
// ends that process, and becomes an ordinary error of ours. It may use memory and time for a file of that size, no more.
#pragma once
#include <string>

#include "framework/scene/value_lists.h"

namespace stroma {

/// A program that reads files for this one.
struct ReaderProgram {
  std::string name;     ///< in moduleFolder(), or a path
  std::string reader;   ///< who reads there, for messages: "VTK's reader"
  std::string missing;  ///< why the program may not be there, and what helps
};

/// Runs the program on a file and returns what it hands over. Throws ComponentError: what it complains of, or how it
/// ended. May be called from any thread; ends when the program does.
ValueLists readInOwnProcess(const ReaderProgram& program, const std::string& file, const Texts& arguments = {});

// ---- in the program ----

/// `read` gets the file and the arguments; a ComponentError or std::bad_alloc of it reaches the other side.
using ReadFunction = ValueLists (*)(const std::string& file, const Texts& arguments);

/// All of main().
int runReader(int argc, char** argv, ReadFunction read);

/// To be called by `read` when it knows the format: reading may take `memory_per_byte` bytes for each of the file's, on
/// top of what a program takes anyway, and computing time by its size.
void limitReader(double file_bytes, double memory_per_byte);

}  // namespace stroma
