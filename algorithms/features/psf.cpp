#include "algorithms/features/psf.h"

#include <functional>

#include "algorithms/core/errors.h"
#include "algorithms/core/fields.h"
#include "algorithms/features/psf_spectral.h"
#include "algorithms/features/psf_whitening.h"

namespace gaitcam {
namespace {

struct EstimatorEntry {
  PsfEstimatorInfo info;
  std::function<std::unique_ptr<PsfEstimator>()> make;
};

std::vector<EstimatorEntry> Entries() {
  return {{{"spectral", "power spectrum against that of a line"}, [] { return std::make_unique<SpectralPsf>(); }},
          {{"spectral_light", "the same of light and not of grey values"},
           [] {
             SpectralOptions options;
             options.light = true;
             return std::make_unique<SpectralPsf>(options);
           }},
          {{"whitening", "least derivatives and their auto-correlation (thesis, section 5.2.1)"},
           [] { return std::make_unique<WhiteningPsf>(); }}};
}

}  // namespace

std::vector<PsfEstimatorInfo> ListPsfEstimators() {
  std::vector<PsfEstimatorInfo> infos;
  for (const EstimatorEntry& entry : Entries()) infos.push_back(entry.info);
  return infos;
}

std::unique_ptr<PsfEstimator> MakePsfEstimator(const std::string& name) {
  std::vector<std::string> names;
  for (const EstimatorEntry& entry : Entries()) {
    if (entry.info.name == name) return entry.make();
    names.push_back(entry.info.name);
  }
  throw BadInput("unknown estimator of the point spread function \"" + name + "\"; " + DidYouMean(name, names));
}

}  // namespace gaitcam
