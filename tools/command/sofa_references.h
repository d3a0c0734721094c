// SPDX-License-Identifier: LGPL-2.1-or-later
// SOFA's lists of scenes to repeat, and the states that it stored for them.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "framework/scene/types.h"

namespace stroma::command {

/// One line: SCENE STEPS EPSILON [MAPPED TOO 0|1] [LAST ONLY 0|1] [PERIOD].
struct SofaCase {
  std::string name;   ///< as the list has it
  std::string scene;  ///< the file
  long steps = 100;
  double epsilon = 1e-4;
  bool mapped_too = false;
  bool last_only = false;
  double period = 0;                    ///< time between stored instants [s]; 0: not given
  std::vector<std::string> references;  ///< files, by the number in their name
};

/// Positions of one state at the times that were stored.
struct SofaReference {
  std::string state;  ///< its name
  int number = 0;     ///< of the state in the tree
  std::map<double, std::vector<double>> positions;  ///< [m], three numbers per point, seven per frame
};

bool isSofaList(const std::string& file);
/// The lists below a folder, in the order of their names. What SOFA calls topology tests has no states, and is left out.
std::vector<std::string> sofaListsIn(const std::string& folder);
/// The scenes are looked for beside the list, in the folders of REGRESSION_SCENES_DIR and on the data paths. Throws
/// std::runtime_error.
std::vector<SofaCase> readSofaList(const std::string& file);
/// Text, JSON or CSV, also compressed. Throws std::runtime_error for what is missing, cut short or no number.
SofaReference readSofaReference(const std::string& file);

}  // namespace stroma::command
