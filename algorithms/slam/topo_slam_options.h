/// Options of topo_slam.h: what a scenario's `system` may set.

#pragma once

#include "algorithms/core/fields.h"
#include "algorithms/places/loop_filter.h"
#include "algorithms/places/panorama.h"
#include "algorithms/places/steady_view.h"
#include "algorithms/places/wavelet_signature.h"

namespace gaitcam {

struct TopoSlamOptions {
  using DescribedTag = void;
  int width_px = 720;  ///< Of the panoramas; 1830 as the KHR-1HV's.
  int height_px = 160;
  WaveletOptions wavelet;
  PanoramaOptions panorama;
  LoopFilterOptions loop;
  bool look_around = true;  ///< A loop is closed by a panorama only, never by a single view.
  double same_place =
      1.65;  ///< Similarity from which on two panoramas show one place; loop.threshold is that of a view.
  double sector_slack_deg = 15;           ///< How far a panorama's sectors may slide, see panorama_match.h.
  double place_steps = 20;                ///< A place is out of reach if it lies farther away, by counted steps, ...
  double step_error = 0.04;               ///< ... than this and such a share of the steps made since it was visited.
  double test_every_s = 0.3;              ///< Time between two tests.
  Steadiness steady = Steadiness::kGyro;  ///< Which frame of that time is tested.
  bool level_views = true;                ///< By gravity as the IMU senses it; without one, by the standing camera's.
  double heading_window_deg = 45;  ///< A view lies within this of its heading by gyroscope; 180: anywhere, as in the
                                   ///< thesis.
  double clearer = 1.2;  ///< The filter is asked although the last place still fits, if another one fits so many times
                         ///< better; 1000: never, as in the thesis.
  int persist = 3;       ///< Consecutive tests that must agree.
  double rest_after_scan_s = 2;  ///< After a scan, until the head looks ahead again. Tests go on once a foot is lifted.
  double scan_patience_s = 120;  ///< A scan that takes longer has failed.
};

template <class Visitor>
void VisitFields(Visitor& visit, TopoSlamOptions& o) {
  visit("width_px", o.width_px, Between(16, 100000), "of a panorama");
  visit("height_px", o.height_px, Between(8, 10000), "of a panorama");
  visit("wavelet", o.wavelet, Nested(), "the signature of a place");
  visit("panorama", o.panorama, Nested(), "how frames of a scan are stitched");
  visit("loop", o.loop, Nested(), "how known places are recognised");
  visit("look_around", o.look_around, Nested(), "a loop is closed by a panorama only, never by a single view");
  visit("same_place", o.same_place, Between(1.0, 1000.0), "similarity from which on two panoramas show one place");
  visit("sector_slack_deg", o.sector_slack_deg, Between(0.0, 90.0), "how far a sector of a panorama may slide");
  visit("place_steps", o.place_steps, Between(1.0, 1e6), "a place farther away, in counted steps, is out of reach");
  visit("step_error", o.step_error, Between(0.0, 1000.0),
        "added to place_steps: share of the steps since it was visited");
  visit("test_every_s", o.test_every_s, Between(0.0, 1000.0), "time between two tests");
  visit("steady", o.steady, EnumWords<Steadiness>(), "which frame of that time is tested");
  visit("level_views", o.level_views, Nested(), "views are projected onto the cylinder by gravity");
  visit("heading_window_deg", o.heading_window_deg, Between(1.0, 180.0),
        "a view lies within this of the gyroscope's heading");
  visit("clearer", o.clearer, Between(1.0, 1000.0),
        "a place that fits so many times better than the last is tested even if that still fits");
  visit("persist", o.persist, Between(1, 1000), "consecutive tests that must agree");
  visit("rest_after_scan_s", o.rest_after_scan_s, Between(0.0, 60.0), "after a scan, until the head looks ahead again");
  visit("scan_patience_s", o.scan_patience_s, Between(1.0, 1e5), "a scan that takes longer has failed");
}

}  // namespace gaitcam
