/// People in a scene: who they are, where they walk and how they look.
///
/// A person is a moving visual only, without contact or mass. Who walks a path of his own avoids nobody; people of a
/// crowd (crowd.h) avoid each other, what stands about and the robot.

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "algorithms/core/option_reader.h"

namespace gaitcam {

/// Where somebody is to be over time. Stands at the first pose before it begins, and at the last one after its end.
struct PersonCourse {
  double begin_s = 0, step_s = 0.1;    ///< Time of the first pose; from one to the next.
  std::vector<Eigen::Vector3d> poses;  ///< x m, y m, yaw rad (not wrapped) of the body.
};

/// What somebody does who does not walk.
struct PersonManner {
  double seat_m = 0;   ///< Sits so high over the floor; 0: stands.
  double talks = 0;    ///< How large gestures are, 0 to 1.
  double looks = 0;    ///< How far the head turns to either side, rad.
  double phase_s = 0;  ///< By which gestures and looks are ahead of others'.
};

/// One person, as a scene's or a scenario's list `people` says it.
///
///   people:
///     - {name: passer-by, path: [[1, -2], [1, 2]], repeat: true, speed_m_s: 1.1, start_s: 3}
///     - {name: onlooker, path: [[2, 0.5]], speed_m_s: 0, facing_deg: 180}
struct PersonOptions {
  using DescribedTag = void;
  std::string name;
  std::vector<Eigen::Vector2d> path;
  bool repeat = false;
  double speed_m_s = 1.2;
  double start_s = 0;
  double facing_deg = 0;
  double height_m = 1.75;
  double girth = 1;
  Eigen::Vector3d trousers_rgb{0.2, 0.24, 0.36};
  Eigen::Vector3d top_rgb{0.62, 0.2, 0.17};
  Eigen::Vector3d shoes_rgb{0.13, 0.12, 0.12};
  Eigen::Vector3d soles_rgb{0.85, 0.84, 0.8};
  Eigen::Vector3d skin_rgb{0.8, 0.6, 0.48};
  Eigen::Vector3d hair_rgb{0.22, 0.15, 0.1};
  uint64_t seed = 0;

  /// Not in files: what a crowd's simulation makes of somebody, who then walks this instead of `path`.
  std::shared_ptr<const PersonCourse> course;
  PersonManner manner;  ///< Likewise.
};

template <class Visitor>
void VisitFields(Visitor& visit, PersonOptions& o) {
  visit("name", o.name, AnyText(), "for people");
  visit("path", o.path, Nested(), "corners of the path over the floor: [[x m, y m], ...]");
  visit("repeat", o.repeat, Nested(), "walks back and forth for ever; otherwise stops at the last corner");
  visit("speed_m_s", o.speed_m_s, Between(0, 2),
        "while walking straight on; turns on the spot take time of their own. 0: stands at the path's first corner");
  visit("start_s", o.start_s, Between(0, 36000), "stands at the first corner until then");
  visit("facing_deg", o.facing_deg, AnyNumber(), "where somebody looks whose path has one point only; 0 is +x");
  visit("height_m", o.height_m, Between(0.8, 2.2), "from the floor to the top of the head");
  visit("girth", o.girth, Between(0.8, 1.3), "how thick trunk and limbs are, as a factor");
  visit("trousers_rgb", o.trousers_rgb, Nested(), "display values 0..1");
  visit("top_rgb", o.top_rgb, Nested(), "display values 0..1");
  visit("shoes_rgb", o.shoes_rgb, Nested(), "display values 0..1");
  visit("soles_rgb", o.soles_rgb, Nested(), "display values 0..1");
  visit("skin_rgb", o.skin_rgb, Nested(), "display values 0..1");
  visit("hair_rgb", o.hair_rgb, Nested(), "display values 0..1");
  visit("seed", o.seed, AtLeast(0), "which part of the cloth the clothes are cut from");
}

/// Reads one person and checks the path and the colours.
/// @throws BadInput naming file, line, key and what is expected.
void ReadOption(const OptionValue& node, PersonOptions& person);

}  // namespace gaitcam
