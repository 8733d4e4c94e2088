/// A memory of places for a robot that walks on: features of a view in, which earlier place it shows out, or a new one.
///
/// Beside PlaceIndex (place_recognition.h), which compares views with panoramas: here a place is one view of the film
/// and nothing is known of headings. FAB-MAP, PIRF-nav 2.0, the appearance SLAM of Hua 4.2 and a bag of words all
/// answer this way, so that they can be put in one another's place and scored alike.
///
/// Source, where it says "Hua": G. Hua, A Robust Visual-Feature-Extraction Method in Public Environment, doctoral
/// thesis, Tokyo Institute of Technology, 2015, chapters 2 and 4.

#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "algorithms/features/features.h"

namespace gaitcam {

struct PlaceAnswer {
  int place = -1;             ///< The likeliest of the places asked about; -1: nothing speaks for any.
  bool known = false;         ///< The method takes the view for that place; false: for a new one.
  double confidence = 0;      ///< That it is that place and no new one: what a threshold is put on. Its scale is the
                              ///< method's own; the greater, the surer. Means nothing where `place` is -1.
  std::vector<double> score;  ///< Of each place asked about, >= 0; the greater, the likelier.
};

class PlaceMemory {
 public:
  virtual ~PlaceMemory() = default;
  /// A new place: what its view shows. Places are numbered in this order; neighbours in it are neighbours on the way.
  /// @throws BadInput for descriptors of another type or length than the memory's.
  virtual void Add(const Features& view) = 0;
  /// Views are asked about in the order of the film: a memory may expect the next one near the last answer.
  /// @param first_places only the first so many places may be the answer; later ones were seen a moment ago, and look
  /// like the view for no other reason. @pre first_places <= size(). @throws as Add().
  virtual PlaceAnswer Ask(const Features& view, size_t first_places) = 0;
  virtual size_t size() const = 0;
  /// What the memory of all places takes, divided by their number; 0 if there are none. What was learned before any
  /// place was seen (a vocabulary) is not in it.
  virtual double bytes_per_place() const = 0;
};

}  // namespace gaitcam
