#include "distance.hpp"

#include <cmath>
#include <limits>

#include <coal/distance_func_matrix.h>

namespace humanoid_rail {

namespace {

const coal::DistanceFunctionMatrix& distance_functions() {
  static const coal::DistanceFunctionMatrix functions;
  return functions;
}

// coal's search ends when the distance is this precise; the normal is as precise as the root of it. Of round faces that
// is too little by default. Below this, bodies of 100 m give no distance at all.
constexpr double CYLINDER_TOLERANCE = 1e-10;

bool is_round(coal::NODE_TYPE kind) { return kind == coal::GEOM_CAPSULE || kind == coal::GEOM_SPHERE; }

}  // namespace

DistanceMeter::DistanceMeter(bool depths) : request_(true, depths), cylinder_request_(request_), solver_(request_) {
  cylinder_request_.gjk_tolerance = CYLINDER_TOLERANCE;
}

void DistanceMeter::measure(const coal::CollisionGeometry& a, const coal::Transform3s& placement_a,
                            const coal::CollisionGeometry& b, const coal::Transform3s& placement_b, Nearest& nearest) {
  const auto kind_a = a.getNodeType(), kind_b = b.getNodeType();
  // Between round shapes distances have closed forms.
  const bool is_cylinder = kind_a == coal::GEOM_CYLINDER || kind_b == coal::GEOM_CYLINDER;
  if (!is_round(kind_a) || !is_round(kind_b)) solver_.set(is_cylinder ? cylinder_request_ : request_);
  result_.min_distance = std::numeric_limits<double>::max();
  distance_functions().distance_matrix[kind_a][kind_b](&a, placement_a, &b, placement_b, &solver_, request_, result_);
  nearest.distance = result_.min_distance;
  nearest.normal = result_.normal;
  // Where it computes no depth coal has no normal either.
  if (!request_.enable_signed_distance && std::isnan(nearest.normal[0])) nearest.distance = -INFINITE;
  nearest.point = result_.nearest_points[0];
}

}  // namespace humanoid_rail
