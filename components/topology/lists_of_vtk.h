// SPDX-License-Identifier: LGPL-2.1-or-later
// Names of the lists that the program read_vtk_mesh hands over.
#pragma once

namespace stroma::vtk_lists {

inline constexpr const char* points = "points";    ///< [m], three each
inline constexpr const char* types = "types";      ///< of cells, VTK's numbers
inline constexpr const char* offsets = "offsets";  ///< of cells in `nodes`, one more than cells
inline constexpr const char* nodes = "nodes";
inline constexpr const char* kinds = "kinds";                ///< VTK's numbers of the types that occur
inline constexpr const char* kinds_linear = "kinds linear";  ///< 1 for those whose nodes are their corners
inline constexpr const char* kinds_names = "kinds names";    ///< what VTK calls them
inline constexpr const char* cell_arrays = "cell arrays";    ///< names
inline constexpr const char* point_arrays = "point arrays";  ///< names
inline constexpr const char* labels = "labels";              ///< values, as those of the next three
inline constexpr const char* cell_directions = "cell directions";
inline constexpr const char* point_directions = "point directions";
inline constexpr const char* cell_values = "cell values";
inline constexpr const char* width = " width";  ///< after the name of one of the last four: values of each entry

}  // namespace stroma::vtk_lists
