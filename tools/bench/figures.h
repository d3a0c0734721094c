// SPDX-License-Identifier: LGPL-2.1-or-later
// What is measured, one function a group.
#pragma once
#include "tools/bench/figure.h"

namespace stroma::bench {

/// Products, forces, energy and assembly, reached through the role of a force field.
void addKernelFigures(Catalogue& catalogue);
/// Products, forces and assembly of hexahedra.
void addHexahedronFigures(Catalogue& catalogue);
/// The same of tetrahedra of ten nodes.
void addQuadraticFigures(Catalogue& catalogue);
/// The same work on one thread and on two.
void addThreadFigures(Catalogue& catalogue);
/// Whole steps of the scenes of scenes/benchmarks and of the organs.
void addStepFigures(Catalogue& catalogue);
/// The shape memory of neighbourhoods: forces and whole explicit steps.
void addShapeMemoryFigures(Catalogue& catalogue);
/// Laws of large strains on tetrahedra: kernels and whole steps, beside the textbook's discretisation.
void addHyperelasticFigures(Catalogue& catalogue);
/// Chains of rigid frames.
void addFrameFigures(Catalogue& catalogue);
/// Processes from start to end.
void addStartFigures(Catalogue& catalogue);

}  // namespace stroma::bench
