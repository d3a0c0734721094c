# SPDX-License-Identifier: LGPL-2.1-or-later
# Core seconds, to be written anew when tests change much: user and system seconds of each alone, above 4.
# Those of a browser come one after the other, so they stand above all: together they take longest.
foreach(cost
    120:docs.site 110:view.page 100:view.page_of_every_example 90:view.contact_page
    24:tools.CheckAndRunAgree 16:sofa.elements 9:sofa.steps 24:hyperelasticity.PorousConsolidation 22:contact.PublishedBenchmarks
    21:meshing.MeshCommand 20:sweep.Sweep 10:tools.Examples/CheckAndRunAgreeOn.0 10:tools.Examples/CheckAndRunAgreeOn.1
    19:view.messages 13:stability.All/Matrix.2 11:stability.All/Matrix.6 10:stability.All/Matrix.0 11:stability.All/BadShapes
    8:stability.All/Matrix.4 10:sweep.ParallelEngine 8:stability.All/Matrix.3 6:stability.All/Matrix.5 7:stability.All/Matrix.7
    17:project.package 10:budgets.standing_set 8:project.huge_pages 13:project.bits 12:docs.page.picture 10:docs.page.README
    10:editor.acceptance 10:validation.Cantilever 11:contact.Drops 9:python.sofa_command 9:python.sofa_public
    9:project.module_outside_the_tree 10:contact.ConstraintClosedForms 8:project.compiler_cache 8:tools.Words 8:tools.run_manners
    8:editor.emacs 8:sofa.folders 8:python.sofa_ways 8:validation.All/ElasticaOfMethod 7:hyperelasticity.HyperelasticNewton
    7:stability.Recovery 7:budgets.idle_parts 5:contact.ConstraintBodies 16:contact.Arch 6:project.mutants 6:project.fuzzed_scenes 6:python.sofa_rows
    6:picture.EveryExample 6:docs.page.developer 6:iterative_solvers.AutomaticPreconditioner 5:docs.page.python 5:sofa.constraints 5:sofa.springs
    5:validation.All/CalculiXBlocks 5:iterative_solvers.Multigrid 5:python.episodes 5:hyperelasticity.MeanDilatation)
  string(REGEX MATCH "^([0-9]+):(.*)" cost "${cost}")
  set_tests_properties("${CMAKE_MATCH_2}" PROPERTIES COST ${CMAKE_MATCH_1})
endforeach()
