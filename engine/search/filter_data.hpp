// What the sampled filter of edges computes with: a robot among obstacles as plain numbers in single precision. The
// kernels that read it are compiled for several processors, so nothing here is more than a struct of plain numbers: a
// function of a library that was compiled for one processor must not be called on another.
#pragma once

namespace humanoid_rail {

// Configurations that are looked at at once.
constexpr int LANES = 8;

// A joint about, or along, the z axis of its frame.
struct FilterJoint {
  int parent = 0;
  bool slides = false;
  float rotation[9] = {};            // Of its frame at 0 in the parent's, row by row.
  float translation[3] = {};         // m
  float offset = 0.0F;               // Its coordinate is this ...
  int first_term = 0, end_term = 0;  // ... and the sum of these.
};

// A share of an actuated joint's coordinate.
struct FilterTerm {
  int column = 0;
  float factor = 0.0F;
};

// A body: the points that are within a radius of a straight piece, or are covered by them.
struct FilterBody {
  int joint = 0;
  float from[3] = {}, to[3] = {};  // In the frame of the joint, m.
  float half_length = 0.0F;        // Of the straight piece, m.
  float radius = 0.0F;             // m
  bool exact = false;
};

enum class FilterShape { ROUND, BOX, PLANE };

// A piece of an obstacle, or a shape that covers it.
struct FilterPiece {
  FilterShape shape = FilterShape::ROUND;
  float middle[3] = {};    // Of a round or box, m.
  float axis[3] = {};      // Of a round: half of its straight piece, m. Of a plane: its normal.
  float rotation[9] = {};  // Of a box, row by row.
  float half[3] = {};      // Of a box, half of its sides, m.
  float radius = 0.0F;     // Of a round, m. Of a plane: its offset.
  bool exact = false;
};

// Two bodies that may collide.
struct FilterPair {
  int body = 0, other = 0;
  float distance = 0.0F;  // What they have to keep, m.
};

// Everything; arrays belong to whoever fills them in.
struct FilterData {
  int n = 0, joints = 0, bodies = 0, pieces = 0, pairs = 0;
  float distance = 0.0F;               // What bodies have to keep from obstacles, m.
  const FilterJoint* joint = nullptr;  // Parents before children; the first one is the base.
  const FilterTerm* term = nullptr;
  const FilterBody* body = nullptr;
  const char* moves = nullptr;  // Whether a body moves.
  const FilterPiece* piece = nullptr;
  // Boxes around the pieces, grown by the distance, coordinate by coordinate, filled up to whole lanes by boxes that
  // nothing meets: low x, low y, low z, high x, high y, high z.
  const float* boxes[6] = {};
  const FilterPair* pair = nullptr;
};

// A pair that may be too near in some lanes.
struct Undecided {
  int body = 0;
  int piece = -1;  // Of an obstacle; -1 for a pair of bodies, ...
  int pair = -1;   // ... which has this number.
  unsigned lanes = 0;
};

// Numbers of workspace that a kernel needs.
[[nodiscard]] constexpr int filter_workspace(int joints, int bodies) { return LANES * (12 * joints + 6 * bodies); }

// Looks at configurations, given coordinate by coordinate: (n, LANES). Returns the lanes in which a pair is too near,
// and adds the pairs that it cannot tell of. Once a lane is known to be blocked nothing more is looked at.
using FilterKernel = unsigned (*)(const FilterData& data, const float* q, float* workspace, Undecided* undecided,
                                  int* count);

// The same function, for any processor and for those with AVX2. They agree to the last bit.
unsigned filter_portably(const FilterData& data, const float* q, float* workspace, Undecided* undecided, int* count);
#ifdef HUMANOID_RAIL_AVX2
unsigned filter_by_avx2(const FilterData& data, const float* q, float* workspace, Undecided* undecided, int* count);
#endif

}  // namespace humanoid_rail
