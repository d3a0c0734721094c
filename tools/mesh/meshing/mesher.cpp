// SPDX-License-Identifier: LGPL-2.1-or-later
// Both kinds of domain with CGAL's Mesh_3: from a domain, criteria and first points to a mesh whose slivers have been worked
// on. In one unit and with one type of domain, because what Mesh_3 does is compiled once for each type.
#include "tools/mesh/meshing/mesher.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_3/Mesher_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Polyhedral_mesh_domain_with_features_3.h>
#include <CGAL/Random.h>
#include <CGAL/exude_mesh_3.h>
#include <CGAL/make_mesh_3.h>
#include <CGAL/perturb_mesh_3.h>

#include "framework/scene/diagnostics.h"
#include "tools/mesh/meshing/surface_mesh.h"

namespace stroma::meshing {
namespace {

namespace par = CGAL::parameters;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

/// A closed surface of triangles. A point is inside when a ray from it crosses the surface an odd number of times, so a
/// closed surface inside of another one is a hollow.
using SurfaceDomain = CGAL::Polyhedral_mesh_domain_with_features_3<Kernel>;
/// The regions of a LabelField. The surface between two regions has a number too, see SurfaceNumbers.
using FieldDomain = CGAL::Labeled_mesh_domain_3<Kernel, int, int>;
using Triangulation = CGAL::Mesh_triangulation_3<SurfaceDomain, CGAL::Default, CGAL::Sequential_tag>::type;
using Complex =
    CGAL::Mesh_complex_3_in_triangulation_3<Triangulation, SurfaceDomain::Corner_index, SurfaceDomain::Curve_index>;
using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

/// Either kind of domain: what refinement and the treatment of slivers ask of it (a model of CGAL's MeshDomain_3).
class Domain {
 public:
  using R = SurfaceDomain::R;
  using FT = R::FT;
  using Point_3 = R::Point_3;
  using Vector_3 = R::Vector_3;
  using Segment_3 = R::Segment_3;
  using Ray_3 = R::Ray_3;
  using Line_3 = R::Line_3;
  using Subdomain_index = int;
  using Surface_patch_index = int;
  using Index = int;
  using Subdomain = boost::optional<int>;
  using Surface_patch = boost::optional<int>;
  using Intersection = std::tuple<Point_3, int, int>;

  struct Is_in_domain {
    const Domain& domain;
    Subdomain operator()(const Point_3& p) const { return domain.regionAt(p); }
  };
  struct Do_intersect_surface {
    const Domain& domain;
    template <class Query>
    Surface_patch operator()(const Query& query) const {
      return domain.surfaceOn(query);
    }
  };
  struct Construct_intersection {
    const Domain& domain;
    template <class Query>
    Intersection operator()(const Query& query) const {
      return domain.crossing(query);
    }
  };

  virtual ~Domain() = default;
  Is_in_domain is_in_domain_object() const { return {*this}; }
  Do_intersect_surface do_intersect_surface_object() const { return {*this}; }
  Construct_intersection construct_intersection_object() const { return {*this}; }
  virtual CGAL::Bbox_3 bbox() const = 0;
  Index index_from_surface_patch_index(int patch) const { return patch; }
  Index index_from_subdomain_index(int region) const { return region; }
  int surface_patch_index(Index index) const { return index; }
  int subdomain_index(Index index) const { return index; }

 private:
  virtual Subdomain regionAt(const Point_3& p) const = 0;
  virtual Surface_patch surfaceOn(const Segment_3& query) const = 0;
  virtual Surface_patch surfaceOn(const Ray_3& query) const = 0;
  virtual Surface_patch surfaceOn(const Line_3& query) const = 0;
  virtual Intersection crossing(const Segment_3& query) const = 0;
  virtual Intersection crossing(const Ray_3& query) const = 0;
  virtual Intersection crossing(const Line_3& query) const = 0;
};

template <class Made>
class DomainOf final : public Domain {
 public:
  explicit DomainOf(const Made& made) : made_(made) {}
  CGAL::Bbox_3 bbox() const override { return made_.bbox(); }

 private:
  Subdomain regionAt(const Point_3& p) const override { return made_.is_in_domain_object()(p); }
  Surface_patch surfaceOn(const Segment_3& query) const override { return surface(query); }
  Surface_patch surfaceOn(const Ray_3& query) const override { return surface(query); }
  Surface_patch surfaceOn(const Line_3& query) const override { return surface(query); }
  Intersection crossing(const Segment_3& query) const override { return intersection(query); }
  Intersection crossing(const Ray_3& query) const override { return intersection(query); }
  Intersection crossing(const Line_3& query) const override { return intersection(query); }
  template <class Query>
  Surface_patch surface(const Query& query) const {
    return made_.do_intersect_surface_object()(query);
  }
  template <class Query>
  Intersection intersection(const Query& query) const {
    return made_.construct_intersection_object()(query);
  }

  const Made& made_;
};

/// The tetrahedra of the complex with CGAL's numbers of regions as labels, nodes in the order in which the cells need them.
LabelledMesh toLabelledMesh(const Complex& complex) {
  LabelledMesh mesh;
  std::map<Complex::Vertex_handle, stroma::Index> number;
  for (auto cell = complex.cells_in_complex_begin(); cell != complex.cells_in_complex_end(); ++cell) {
    Tetrahedron nodes;
    for (int i = 0; i < 4; ++i) {
      const auto [entry, is_new] = number.emplace(cell->vertex(i), stroma::Index(mesh.position.size()));
      if (is_new) {
        const auto& p = cell->vertex(i)->point();
        mesh.position.emplace_back(CGAL::to_double(p.x()), CGAL::to_double(p.y()), CGAL::to_double(p.z()));
      }
      nodes[i] = entry->second;
    }
    mesh.tetrahedra.push_back(nodes);
    mesh.labels.push_back(complex.subdomain_index(cell));
  }
  return mesh;
}

/// Delaunay refinement from the first points that the complex has until all cells and triangles meet the criteria: CGAL's
/// refine_mesh_3() without its optimisers, which are instantiated there even where none is asked for. Mesher_3 is not
/// documented; this is what refine_mesh_3() of CGAL 5.5 does with it.
void refine(Complex& complex, const Domain& domain, const Criteria& criteria) {
  CGAL::Mesh_3::Mesher_3<Complex, Criteria, Domain>(complex, domain, criteria).refine_mesh();
  complex.clear_manifold_info();
}

/// Perturbs, then exudes, until no dihedral angle is below `aim` [degrees] or nothing helps any more. Both aim higher when
/// angles are left that are poor, at most twice; the best mesh is the result.
LabelledMesh withoutSlivers(Complex& complex, const Domain& domain, double aim) {
  const double poor = least_share * aim;
  LabelledMesh best;
  double best_angle = -1;
  for (int attempt = 0; attempt < 3 && best_angle < poor; ++attempt) {
    const double bound = aim + 2 * attempt;
    CGAL::perturb_mesh_3(complex, domain, par::sliver_bound = bound, par::time_limit = 0);
    Complex weighted = complex;
    CGAL::exude_mesh_3(weighted, par::sliver_bound = bound, par::time_limit = 0);  // weighs the vertices: it must come last
    LabelledMesh mesh = toLabelledMesh(weighted);
    if (mesh.tetrahedra.empty()) return mesh;
    if (const double angle = qualityOf(mesh).smallest_angle; angle > best_angle)
      best = std::move(mesh), best_angle = angle;
  }
  return best;
}

/// The first points of the complex: along the sharp edges of the surface, so that refinement keeps them, and on it. What
/// make_mesh_3() of CGAL 5.5 does before it refines, with an initializer that is not documented.
void protectFeatures(Complex& complex, const SurfaceDomain& domain, const Criteria& criteria) {
  CGAL::Mesh_3::internal::C3t3_initializer<Complex, SurfaceDomain, Criteria, true>()(complex, domain, criteria, true);
}

/// One number for the surface between two regions, `low` below `high`; never 0, which is no surface.
struct SurfaceNumbers {
  int regions;  ///< with the outside
  int operator()(int low, int high) const { return low * regions + high; }
  int low(int number) const { return number / regions; }
  int high(int number) const { return number % regions; }
};

/// RegionSizes as CGAL asks for them.
struct Size {
  using FT = double;
  using Index = int;
  const RegionSizes& sizes;
  SurfaceNumbers numbers;

  double operator()(const Point&, int dimension, Index index) const {
    return dimension == 3 ? sizes.of_region[std::size_t(index)] : sizes.between(numbers.low(index), numbers.high(index));
  }
};

/// First points on every part of every region: refinement finds by itself only what a point already touches.
void insertFirstPoints(Complex& complex, const LabelField& field, const RegionSizes& sizes,
                       const SurfaceNumbers& numbers) {
  for (const LabelField::BoundaryPoint& point : field.boundaryPoints(sizes.spacing())) {
    const Vec3& p = point.position;
    const auto vertex = complex.triangulation().insert(Triangulation::Weighted_point(Point(p.x(), p.y(), p.z())));
    if (vertex == Complex::Vertex_handle()) continue;
    complex.set_dimension(vertex, 2);
    complex.set_index(vertex, numbers(point.low, point.high));
  }
}

}  // namespace

LabelledMesh meshSurface(const std::vector<Vec3>& position, const std::vector<Triangle>& triangles,
                         const MeshCriteria& criteria) {
  CGAL::get_default_random() = CGAL::Random(0);  // the same mesh each time
  const Surface surface = checkedSurface(position, triangles);
  SurfaceDomain domain(surface);
  domain.detect_features(criteria.feature_angle);
  const double cell = criteria.sizeOf(1), facet = criteria.facet_size > 0 ? criteria.facet_size : cell;
  const Criteria rules(par::edge_size = facet, par::facet_angle = criteria.facet_angle, par::facet_size = facet,
                       par::facet_distance = criteria.distance, par::cell_radius_edge_ratio = 2., par::cell_size = cell);
  Complex complex;
  protectFeatures(complex, domain, rules);
  const DomainOf<SurfaceDomain> asked(domain);
  refine(complex, asked, rules);
  LabelledMesh mesh = withoutSlivers(complex, asked, criteria.dihedral_angle);
  if (mesh.tetrahedra.empty()) throw ComponentError("no cell fits into the surface", "a smaller cell size or distance");
  return mesh;
}

LabelledMesh meshField(const LabelField& field, double accuracy, const RegionSizes& sizes, const MeshCriteria& criteria) {
  CGAL::get_default_random() = CGAL::Random(0);  // the same mesh each time
  const auto [low, high] = field.box();
  const CGAL::Bbox_3 box(low.x(), low.y(), low.z(), high.x(), high.y(), high.z());
  const SurfaceNumbers numbers{int(sizes.of_region.size())};
  const auto label = [&field](const Point& p) { return field.at(Vec3(p.x(), p.y(), p.z())); };
  const FieldDomain domain(label, box, par::relative_error_bound = accuracy / ((high - low).norm() / 2),
                           par::construct_surface_patch_index = numbers);
  const Size size{sizes, numbers};
  const Criteria rules(par::facet_angle = criteria.facet_angle, par::facet_size = size,
                       par::facet_distance = criteria.distance, par::cell_radius_edge_ratio = 2., par::cell_size = size);
  Complex complex;
  insertFirstPoints(complex, field, sizes, numbers);
  const DomainOf<FieldDomain> asked(domain);
  refine(complex, asked, rules);
  return withoutSlivers(complex, asked, criteria.dihedral_angle);
}

}  // namespace stroma::meshing
