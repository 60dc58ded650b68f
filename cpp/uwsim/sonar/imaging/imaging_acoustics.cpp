#include "uwsim/sonar/imaging/imaging_acoustics.h"

#include <algorithm>
#include <cmath>

#include "uwsim/acoustics/absorption.h"
#include "uwsim/core/check.h"
#include "uwsim/core/with_unit.h"
#include "uwsim/sonar/imaging/imaging_kernels.h"

namespace uwsim {
namespace {

constexpr int kMaxLooks = 16;
constexpr int kMaxBins = 20000;
constexpr double kLoudest_db = 300;  // far louder than any transducer; keeps powers within the range of a double

constexpr Parameter kAcousticParameters[] = {
    {"frequency_hz", 1, kRequired, 1e3, 5e6, "Hz", "carrier"},
    {"source_level_db", 1, kRequired, -kLoudest_db, kLoudest_db, "dB", "re 1 uPa at 1 m on the axis"},
    {"noise_level_db", 1, kRequired, -kLoudest_db, kLoudest_db, "dB", "re 1 uPa, in the receiver's band"},
    {"bottom_strength_db", 1, 0, -kLoudest_db, kLoudest_db, "dB", "of the terrain, for labels without a strength"},
    {"solid_strength_db", 1, 0, -kLoudest_db, kLoudest_db, "dB", "of solids, for labels without a strength"},
    {"range_max_m", 1, kRequired, 0.1, 2000, "m", "end of the last range bin"},
    {"range_bins", 1, kRequired, 1, kMaxBins, "", "range resolution cells", ParameterType::kWholeNumber},
    {"time_varied_gain", 1, kRequired, 0, 1, "", "whether levels carry the gain", ParameterType::kFlag},
    {"gain_db_decade", 1, kRequired, 0, 100, "dB", "of the gain, for each decade of range"},
    {"looks", 1, kRequired, 0, kMaxLooks, "", "averaged in a cell; 0: no speckle", ParameterType::kWholeNumber},
    {"multipath", 1, 0, 0, 1, "", "whether echoes by more than one bounce are received", ParameterType::kFlag}};

double power_of(double level_db) { return std::pow(10.0, level_db / 10); }

}  // namespace

std::span<const Parameter> imaging_acoustics_parameters() { return kAcousticParameters; }

ImagingAcoustics imaging_acoustics(const ParameterValues& parameters, const std::vector<double>& strengths_db,
                                   const std::vector<BottomMaterial>& materials) {
  for (const double strength_db : strengths_db) {
    require(std::isnan(strength_db) || std::abs(strength_db) <= kLoudest_db, "sonar.strengths_db",
            with_unit(strength_db, "dB"), "must be in [-300, 300] dB");
  }
  ImagingAcoustics acoustics;
  acoustics.frequency_hz = number(parameters, "frequency_hz");
  acoustics.source_level_db = number(parameters, "source_level_db");
  acoustics.noise_level_db = number(parameters, "noise_level_db");
  acoustics.bottom_strength_db = number(parameters, "bottom_strength_db");
  acoustics.solid_strength_db = number(parameters, "solid_strength_db");
  acoustics.strengths_db = strengths_db;
  acoustics.range_max_m = number(parameters, "range_max_m");
  acoustics.range_bins = whole_number(parameters, "range_bins");
  acoustics.time_varied_gain = flag(parameters, "time_varied_gain");
  acoustics.gain_db_decade = number(parameters, "gain_db_decade");
  acoustics.looks = whole_number(parameters, "looks");
  acoustics.multipath = flag(parameters, "multipath");
  acoustics.materials = materials;
  return acoustics;
}

double ImagingAcoustics::strength(Label label) const {
  if (label < strengths_db.size() && !std::isnan(strengths_db[label])) return power_of(strengths_db[label]);
  return power_of(label == kTerrain ? bottom_strength_db : solid_strength_db);
}

double ImagingAcoustics::absorption_db_m(const Water& water, double head_z_m) const {
  return absorption_db_km(frequency_hz, water.temperature_deg_c(head_z_m), water.salinity_at_psu(head_z_m),
                          std::max(0.0, Water::depth_m(head_z_m))) /
         1000;
}

ImagingReceiver::ImagingReceiver(const ImagingAcoustics& acoustics, double absorption_db_m, const RandomStream& random)
    : random_(random),
      looks_(acoustics.looks),
      source_(power_of(acoustics.source_level_db)),
      noise_(power_of(acoustics.noise_level_db)) {
  for (int bin = 0; bin < acoustics.range_bins; ++bin) {
    const double range_m = acoustics.bin_centre_m(bin);
    const double gain_db = acoustics.gain_db_decade * std::log10(range_m) + 2 * absorption_db_m * range_m;
    gain_db_.push_back(acoustics.time_varied_gain ? static_cast<float>(gain_db) : 0.0f);
  }
}

void ImagingReceiver::receive(const Cells& cells, std::span<const std::complex<float>> speckle, std::span<double> power,
                              std::span<float> level_db) const {
  static const ImagingKernels& kernels = imaging_kernels();
  const ReceiverLanes lanes{source_,    noise_,           looks_,           random_.key(),
                            cells.ping, random_.stream(), cells.first_cell, cells.cell_step};
  kernels.receive(lanes, power.data(), reinterpret_cast<const float*>(speckle.data()), gain_db_.data(), power.size(),
                  power.data(), level_db.data());
}

}  // namespace uwsim
