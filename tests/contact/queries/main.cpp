// SPDX-License-Identifier: LGPL-2.1-or-later
// Published queries of continuous collision detection, put to the filter of BarrierContact: --help.
#include <iostream>

#include "tests/contact/queries/query_file.h"

int main(int count, char** words) { return stroma::test::runQueries({words + 1, words + count}, std::cout, std::cerr); }
