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

bool is_round(coal::NODE_TYPE kind) { return kind == coal::GEOM_CAPSULE || kind == coal::GEOM_SPHERE; }

}  // namespace

void DistanceMeter::measure(const coal::CollisionGeometry& a, const coal::Transform3s& placement_a,
                            const coal::CollisionGeometry& b, const coal::Transform3s& placement_b, Nearest& nearest) {
  const auto kind_a = a.getNodeType(), kind_b = b.getNodeType();
  // Between round shapes distances have closed forms.
  if (!is_round(kind_a) || !is_round(kind_b)) solver_.set(request_);
  result_.min_distance = std::numeric_limits<double>::max();
  distance_functions().distance_matrix[kind_a][kind_b](&a, placement_a, &b, placement_b, &solver_, request_, result_);
  nearest.distance = result_.min_distance;
  nearest.normal = result_.normal;
  // Where it computes no depth coal has no normal either.
  if (!request_.enable_signed_distance && std::isnan(nearest.normal[0])) nearest.distance = -INFINITE;
  nearest.point = result_.nearest_points[0];
}

}  // namespace humanoid_rail
