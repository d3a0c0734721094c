// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <Eigen/Core>
#include <vector>

#include "framework/simulation/node_groups.h"

namespace stroma {

/// Active linear relations C u = 0, in clusters that share no free row. Q projects onto the directions left free by fixed
/// nodes and groups. With an orthonormal basis N of the rows of C Q, the projector onto all free directions is
///   P = Q - N^T N
/// and, with the inverse masses W of the rows, relations act along E = W N^T (N W N^T)^-1: a motion along E needs no
/// force in the range of P. The matrix of a cluster of n rows is dense, (3 n)^2 numbers.
class RelationClusters {
 public:
  /// Sets the relations under these projectors and groups; `inverse_mass` [1/kg], shape (rows) or empty. If a row of a
  /// cluster has inverse mass zero, all its rows are weighted equally.
  void set(const LinearRelations& relations, const std::vector<NodeProjector>& projectors, const NodeGroups& groups,
           const std::vector<double>& inverse_mass);
  bool empty() const { return relations_.count() == 0; }
  const LinearRelations& relations() const { return relations_; }
  /// How many directions they remove in addition to those that are fixed or tied.
  Index heldDirections() const;

  /// vector -= N^T N vector, for a vector projected by Q.
  void project(Rows vector) const;
  /// The same in the metric of the masses: a -= E N a.
  void projectAcceleration(Rows a) const;
  /// Moves velocities along E so that C v = 0, including the velocities of fixed nodes.
  void correctVelocities(Rows v) const;
  /// The same for positions: C (x - rest) = 0.
  void correctPositions(Rows x) const;
  /// The most violated relation, and its violation [m]: |C u| over |C|. -1: there is none.
  struct Violation {
    Index relation = -1;
    double distance = 0;
  };
  Violation worst(ConstRows x) const;

  /// Appends ties that connect the free rows of each cluster: NodeGroups makes the matrix pattern from them.
  void addTies(std::vector<Tie>& ties) const;
  /// Replaces A by P A P + s (I - P), from Q A Q + s (I - Q); s of held_size.h.
  void eliminate(BlockMatrix& matrix) const;
  /// The same for diagonal blocks, shape (rows, 9), assuming that blocks between different rows are zero.
  void eliminateDiagonal(std::vector<double>& blocks) const;

 private:
  struct Cluster {
    std::vector<Index> relations;
    std::vector<Index> rows;     ///< free rows, ascending
    Eigen::MatrixXd basis;       ///< N, shape (rank, 3 rows)
    Eigen::MatrixXd along;       ///< E, shape (3 rows, rank)
    Eigen::MatrixXd correction;  ///< E times the matrix that maps C u to N u; shape (3 rows, relations)
  };
  /// The entry of a row in a relation of C Q, each relation scaled to length one.
  struct FreeTerm {
    Index relation, row;
    Vec3 coefficients;
  };
  std::vector<FreeTerm> freeTerms(const std::vector<NodeProjector>& projectors, const NodeGroups& groups) const;
  void makeClusters(const std::vector<FreeTerm>& terms, Index rows);
  void factorise(Cluster& cluster, const std::vector<FreeTerm>& terms, const std::vector<double>& inverse_mass) const;
  template <class Value>
  void correct(Rows vector, const Value& valueOf) const;

  LinearRelations relations_;
  std::vector<double> lengths_;  ///< |C Q| of each relation
  std::vector<Cluster> clusters_;
  mutable Eigen::VectorXd gathered_, reduced_, off_;  ///< work space
};

}  // namespace stroma
