// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <Eigen/Core>
#include <vector>

#include "framework/simulation/node_groups.h"

namespace stroma {

/// Linear relations C u = 0 in force, in clusters that share no free row. Q projects onto what held nodes and groups
/// leave free. With N an orthonormal basis of the rows of C Q, the projector onto all that is free is
///   P = Q - N^T N
/// and, with the inverse masses W of the rows, relations act along E = W N^T (N W N^T)^-1: a motion along E needs no
/// force that P would let through. The matrix of a cluster of n rows is full, (3 n)^2 numbers.
class RelationClusters {
 public:
  /// Relations under these projectors and groups; `inverse_mass` [1/kg], shape (rows) or empty. In a cluster
  /// where one is zero (no mass), all rows weigh the same.
  void set(const LinearRelations& relations, const std::vector<NodeProjector>& projectors, const NodeGroups& groups,
           const std::vector<double>& inverse_mass);
  bool empty() const { return relations_.count() == 0; }
  const LinearRelations& relations() const { return relations_; }
  /// How many directions they take away beyond those that are held and tied.
  Index heldDirections() const;

  /// vector -= N^T N vector, for a vector that Q has projected.
  void project(Rows vector) const;
  /// The same in the metric of the masses: a -= E N a.
  void projectAcceleration(Rows a) const;
  /// Moves velocities along E until C v = 0, the velocities of fixed nodes included.
  void correctVelocities(Rows v) const;
  /// The same for positions: C (x - rest) = 0.
  void correctPositions(Rows x) const;
  /// The relation with the largest violation, and its size [m]: |C u| over |C|. -1: there is none.
  struct Violation {
    Index relation = -1;
    double distance = 0;
  };
  Violation worst(ConstRows x) const;

  /// Appends ties that hang the free rows of each cluster together: NodeGroups makes the matrix's pattern from them.
  void addTies(std::vector<Tie>& ties) const;
  /// A becomes P A P + s (I - P), from Q A Q + s (I - Q); s of held_size.h.
  void eliminate(BlockMatrix& matrix) const;
  /// The same for diagonal blocks, shape (rows, 9), with the blocks between different rows taken for zero.
  void eliminateDiagonal(std::vector<double>& blocks) const;

 private:
  struct Cluster {
    std::vector<Index> relations;
    std::vector<Index> rows;     ///< the free ones, ascending
    Eigen::MatrixXd basis;       ///< N, shape (rank, 3 rows)
    Eigen::MatrixXd along;       ///< E, shape (3 rows, rank)
    Eigen::MatrixXd correction;  ///< E times what gives N u from C u; shape (3 rows, relations)
  };
  /// What a row has of a relation of C Q, each relation scaled to length one.
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
