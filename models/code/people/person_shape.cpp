#include "models/code/people/person_shape.h"

#include <cmath>

#include "algorithms/core/random.h"

namespace gaitcam {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kAround = 16;  // corners of a cross-section

/// A cross-section: a superellipse about a centre. Exponent 2 is an ellipse, more is boxier.
struct Ring {
  Vector3d center, a, b;  ///< Half axes; a x b points towards the next ring.
  double exponent = 2;

  Vector3d Corner(int i) const {
    const double angle = 2 * M_PI * i / kAround;
    const auto bent = [this](double x) { return std::copysign(std::pow(std::abs(x), 2 / exponent), x); };
    return center + bent(std::cos(angle)) * a + bent(std::sin(angle)) * b;
  }
};

/// The broadest core between two cross-sections of a loft, or none. The loft's triangles dent an ellipse of 16 corners
/// by 2 %; where neighbouring cross-sections differ in shape, by a little more.
SolidCore CoreBetween(const std::vector<Ring>& rings, size_t from, size_t to) {
  constexpr double kDented = 0.96;
  const Ring &start = rings[from], &end = rings[to];
  const Vector3d along = end.center - start.center;
  double scale = kDented;
  for (size_t k = from + 1; k < to; ++k) {
    const double part = (rings[k].center - start.center).dot(along) / along.squaredNorm();
    const double a = rings[k].a.norm(), b = rings[k].b.norm();
    const double aside = (rings[k].center - start.center - part * along).norm() / std::min(a, b);
    const double broad =
        std::max((start.a + part * (end.a - start.a)).norm() / a, (start.b + part * (end.b - start.b)).norm() / b);
    scale = std::min(scale, (kDented - aside) / broad);
  }
  if (scale <= 0) return {};
  return {{{{start.center, scale * start.a, scale * start.b}, {end.center, scale * end.a, scale * end.b}}}};
}

double Silhouette(const SolidCore& core) {
  const auto breadth = [](const SolidCore::Disc& disc) { return std::min(disc.a.norm(), disc.b.norm()); };
  return (core.ends[1].center - core.ends[0].center).norm() * (breadth(core.ends[0]) + breadth(core.ends[1]));
}

/// Of all such cores the one with the largest silhouette.
SolidCore CoreOf(const std::vector<Ring>& rings) {
  SolidCore best;
  for (size_t from = 0; from < rings.size(); ++from) {
    for (size_t to = from + 1; to < rings.size(); ++to) {
      const SolidCore core = CoreBetween(rings, from, to);
      if (Silhouette(core) > Silhouette(best)) best = core;
    }
  }
  return best;
}

/// Lofts surfaces over cross-sections.
class Tailor {
 public:
  Tailor(const PersonOptions& person, const Vector2d& cloth_size_m)
      : cloth_size_(cloth_size_m), girth_(person.girth), random_(person.seed, "person.cloth") {}

  void Add(PersonPart part, const Vector3d& rgb, bool cloth, std::vector<Ring> rings) {
    if (Thickens(part)) {
      for (Ring& ring : rings) ring.a *= girth_, ring.b *= girth_;
    }
    PersonSurface& surface = SurfaceOf(part, rgb, cloth);
    const Vector2d offset(random_.Uniform(), random_.Uniform());
    const int first = int(surface.vertices.size());
    double along = 0;
    for (size_t k = 0; k < rings.size(); ++k) {
      if (k > 0) along += (rings[k].center - rings[k - 1].center).norm();
      AddRing(rings, k, offset, along, surface);
    }
    for (int k = 0; k + 1 < int(rings.size()); ++k) {
      for (int i = 0; i < kAround; ++i) {
        const int here = first + k * (kAround + 1) + i, next = here + kAround + 1;
        surface.faces.push_back({here, here + 1, next + 1});
        surface.faces.push_back({here, next + 1, next});
      }
    }
    AddCap(rings.front(), -1, offset, surface);
    AddCap(rings.back(), 1, offset, surface);
    const SolidCore core = CoreOf(rings);
    if (Silhouette(core) > Silhouette(surface.core)) surface.core = core;
  }

  std::vector<PersonSurface> surfaces;

 private:
  /// What has one part and one plain colour becomes one mesh: a renderer's time goes with their number.
  PersonSurface& SurfaceOf(PersonPart part, const Vector3d& rgb, bool cloth) {
    for (PersonSurface& surface : surfaces) {
      if (!cloth && !surface.cloth && surface.part == part && surface.rgb == rgb) return surface;
    }
    PersonSurface surface;
    surface.part = part;
    surface.rgb = rgb;
    surface.cloth = cloth;
    surfaces.push_back(surface);
    return surfaces.back();
  }

  void AddRing(const std::vector<Ring>& rings, size_t k, const Vector2d& offset, double along, PersonSurface& surface) {
    const Ring &ring = rings[k], &before = rings[k > 0 ? k - 1 : 0], &after = rings[std::min(k + 1, rings.size() - 1)];
    const double girth = M_PI * (ring.a.norm() + ring.b.norm());
    for (int i = 0; i <= kAround; ++i) {  // the last corner repeats the first with the texture coordinate of the seam
      surface.vertices.push_back(ring.Corner(i % kAround));
      const Vector3d across = ring.Corner(i + 1) - ring.Corner(i - 1);
      surface.normals.push_back(across.cross(after.Corner(i) - before.Corner(i)).normalized());
      surface.texcoords.emplace_back(offset.x() + girth * i / kAround / cloth_size_.x(),
                                     offset.y() - along / cloth_size_.y());
    }
  }

  void AddCap(const Ring& ring, int sign, const Vector2d& offset, PersonSurface& surface) {
    const int first = int(surface.vertices.size());
    const Vector3d normal = sign * ring.a.cross(ring.b).normalized();
    for (int i = -1; i < kAround; ++i) {
      surface.vertices.push_back(i < 0 ? ring.center : ring.Corner(i));
      surface.normals.push_back(normal);
      surface.texcoords.push_back(offset);
    }
    for (int i = 0; i < kAround; ++i) {
      const int a = first + 1 + i, b = first + 1 + (i + 1) % kAround;
      surface.faces.push_back(sign > 0 ? std::array<int, 3>{first, a, b} : std::array<int, 3>{first, b, a});
    }
  }

  /// Trunk and limbs; heads and feet are of one size.
  static bool Thickens(PersonPart part) { return part != PersonPart::kHead && part < PersonPart::kLeftShoe; }

  Vector2d cloth_size_;
  double girth_;
  RandomStream random_;
};

/// Level cross-section of a limb or the trunk: half depth (x) and half width (y).
Ring Level(double z, double depth, double width, double exponent = 2, double x = 0) {
  return {{x, 0, z}, {depth, 0, 0}, {0, width, 0}, exponent};
}

/// A limb between two heights, with round ends that reach beyond them as far as it is thick.
std::vector<Ring> Limb(double low, double low_radius, double high, double high_radius) {
  std::vector<Ring> rings;
  for (const double angle : {0.15, 0.5, 1.0}) {
    const double radius = low_radius * std::sin(angle * M_PI / 2);
    rings.push_back(Level(low - low_radius * std::cos(angle * M_PI / 2), radius, radius));
  }
  for (const double part : {0.33, 0.67, 1.0}) {
    const double radius = low_radius + part * (high_radius - low_radius);
    rings.push_back(Level(low + part * (high - low), radius, radius));
  }
  for (const double angle : {0.5, 0.85}) {
    const double radius = high_radius * std::cos(angle * M_PI / 2);
    rings.push_back(Level(high + high_radius * std::sin(angle * M_PI / 2), radius, radius));
  }
  return rings;
}

/// Upright cross-section of a shoe between two heights.
Ring Across(double x, double half_width, double low, double high, double exponent = 2.6) {
  return {{x, 0, (low + high) / 2}, {0, half_width, 0}, {0, 0, (high - low) / 2}, exponent};
}

PersonPart Side(PersonPart left, int side) { return PersonPart(int(left) + side); }

void AddFoot(const PersonOptions& o, const PersonBody& b, int side, Tailor& tailor) {
  const double h = b.height, sole = 0.014 * h;
  const PersonPart shoe = Side(PersonPart::kLeftShoe, side), toes = Side(PersonPart::kLeftToes, side);
  const double tip = b.toes, heel = -b.heel;
  tailor.Add(shoe, o.soles_rgb, false,
             {Across(heel, 0.016 * h, 0, sole, 5), Across(heel + 0.012 * h, 0.022 * h, 0, sole, 5),
              Across(-0.05 * h, 0.022 * h, 0, sole, 5), Across(0.002 * h, 0.028 * h, 0, sole, 5)});
  tailor.Add(toes, o.soles_rgb, false,
             {Across(-0.002 * h, 0.028 * h, 0, sole, 5), Across(0.6 * tip, 0.026 * h, 0, sole, 5),
              Across(0.9 * tip, 0.018 * h, 0, sole, 5), Across(tip, 0.009 * h, 0, sole, 5)});
  const double base = 0.6 * sole, ankle = 0.068 * h, instep = 0.05 * h, ball = 0.036 * h;
  tailor.Add(shoe, o.shoes_rgb, true,
             {Across(heel + 0.003 * h, 0.011 * h, base, 0.75 * ankle), Across(heel + 0.012 * h, 0.02 * h, base, ankle),
              Across(heel + 0.035 * h, 0.022 * h, base, 1.02 * ankle), Across(-0.06 * h, 0.022 * h, base, 0.95 * ankle),
              Across(-0.04 * h, 0.023 * h, base, instep), Across(-0.02 * h, 0.025 * h, base, 0.042 * h),
              Across(0.004 * h, 0.027 * h, base, ball)});
  tailor.Add(toes, o.shoes_rgb, true,
             {Across(-0.008 * h, 0.0265 * h, base, ball), Across(0.4 * tip, 0.026 * h, base, 0.031 * h),
              Across(0.75 * tip, 0.021 * h, base, 0.026 * h), Across(0.97 * tip, 0.009 * h, base, 0.018 * h)});
  for (int i = 0; i < 3; ++i) {  // laces
    const double x = -0.021 * h - 0.011 * h * i, z = 0.0425 * h + 0.0047 * h * i + (i == 2 ? 0.003 * h : 0);
    const Vector3d a(0, 0, 0.0025 * h), c(0.0022 * h, 0, 0);
    tailor.Add(shoe, o.soles_rgb, false,
               {{{x, -0.013 * h, z - 0.002 * h}, a, c}, {{x, 0, z}, a, c}, {{x, 0.013 * h, z - 0.002 * h}, a, c}});
  }
}

void AddLeg(const PersonOptions& o, const PersonBody& b, int side, Tailor& tailor) {
  const double h = b.height, knee = 0.036 * h;
  // Trousers hang over the shoe.
  std::vector<Ring> shank = {Level(-b.shank + 0.002 * h, 0.037 * h, 0.034 * h),
                             Level(-b.shank + 0.03 * h, 0.036 * h, 0.033 * h),
                             Level(-0.6 * b.shank, 0.037 * h, 0.034 * h, 2, -0.003 * h),
                             Level(-0.3 * b.shank, 0.04 * h, 0.037 * h, 2, -0.006 * h)};
  for (const Ring& ring : Limb(-0.08 * h, knee, 0, knee)) {
    if (ring.center.z() > -0.06 * h) shank.push_back(ring);
  }
  tailor.Add(Side(PersonPart::kLeftShank, side), o.trousers_rgb, true, shank);
  tailor.Add(Side(PersonPart::kLeftThigh, side), o.trousers_rgb, true, Limb(-b.thigh, knee, 0, 0.05 * h));
  AddFoot(o, b, side, tailor);
}

void AddArm(const PersonOptions& o, const PersonBody& b, int side, Tailor& tailor) {
  const double h = b.height;
  const PersonPart forearm = Side(PersonPart::kLeftForearm, side);
  tailor.Add(Side(PersonPart::kLeftUpperArm, side), o.top_rgb, true, Limb(-b.upper_arm, 0.025 * h, 0, 0.032 * h));
  tailor.Add(forearm, o.top_rgb, true,
             {Level(-0.9 * b.forearm, 0.02 * h, 0.02 * h), Level(-0.5 * b.forearm, 0.022 * h, 0.022 * h),
              Level(0, 0.0245 * h, 0.0245 * h), Level(0.02 * h, 0.014 * h, 0.014 * h)});
  const double wrist = -0.88 * b.forearm;
  tailor.Add(forearm, o.skin_rgb, false,
             {Level(wrist - 0.1 * h, 0.008 * h, 0.004 * h, 2, 0.006 * h),
              Level(wrist - 0.085 * h, 0.017 * h, 0.008 * h), Level(wrist - 0.045 * h, 0.024 * h, 0.01 * h),
              Level(wrist - 0.01 * h, 0.014 * h, 0.011 * h), Level(wrist, 0.014 * h, 0.012 * h)});
}

void AddTrunk(const PersonOptions& o, const PersonBody& b, Tailor& tailor) {
  const double h = b.height;
  tailor.Add(PersonPart::kHips, o.trousers_rgb, true,
             {Level(-0.05 * h, 0.03 * h, 0.04 * h), Level(-0.035 * h, 0.055 * h, 0.085 * h, 2.4),
              Level(0.02 * h, 0.064 * h, 0.098 * h, 2.4), Level(b.waist, 0.058 * h, 0.085 * h, 2.4)});
  const double neck = b.neck - b.waist, shoulder = b.shoulder - b.waist;
  tailor.Add(PersonPart::kChest, o.top_rgb, true,
             {Level(-0.05 * h, 0.066 * h, 0.096 * h, 2.4), Level(0.02 * h, 0.061 * h, 0.09 * h, 2.4),
              Level(0.6 * shoulder, 0.068 * h, 0.108 * h, 2.4), Level(0.9 * shoulder, 0.062 * h, 0.118 * h, 2.4),
              Level(shoulder + 0.015 * h, 0.05 * h, 0.11 * h), Level(shoulder + 0.032 * h, 0.038 * h, 0.06 * h),
              Level(neck - 0.002 * h, 0.032 * h, 0.036 * h)});
}

void AddHead(const PersonOptions& o, const PersonBody& b, Tailor& tailor) {
  const double h = b.height, x = 0.008 * h;
  tailor.Add(PersonPart::kHead, o.skin_rgb, false,
             {Level(-0.02 * h, 0.03 * h, 0.03 * h), Level(0.03 * h, 0.029 * h, 0.028 * h)});
  tailor.Add(PersonPart::kHead, o.skin_rgb, false,
             {Level(0.006 * h, 0.018 * h, 0.016 * h, 2, 3.4 * x), Level(0.018 * h, 0.036 * h, 0.03 * h, 2, 1.9 * x),
              Level(0.045 * h, 0.048 * h, 0.04 * h, 2, x), Level(0.08 * h, 0.053 * h, 0.043 * h, 2, 0.5 * x),
              Level(0.11 * h, 0.046 * h, 0.037 * h, 2, 0.3 * x), Level(0.13 * h, 0.022 * h, 0.018 * h)});
  tailor.Add(
      PersonPart::kHead, o.skin_rgb, false,  // nose
      {Level(0.042 * h, 0.012 * h, 0.008 * h, 2, 0.052 * h), Level(0.048 * h, 0.013 * h, 0.007 * h, 2, 0.054 * h),
       Level(0.075 * h, 0.006 * h, 0.005 * h, 2, 0.052 * h)});
  tailor.Add(PersonPart::kHead, o.hair_rgb, true,
             {Level(0.03 * h, 0.026 * h, 0.034 * h, 2, -0.026 * h), Level(0.06 * h, 0.04 * h, 0.046 * h, 2, -0.018 * h),
              Level(0.09 * h, 0.05 * h, 0.047 * h, 2, -0.008 * h), Level(0.115 * h, 0.051 * h, 0.041 * h, 2, 0.001 * h),
              Level(0.134 * h, 0.034 * h, 0.028 * h), Level(0.14 * h, 0.01 * h, 0.008 * h)});
}

}  // namespace

std::vector<PersonSurface> PersonSurfaces(const PersonOptions& person, const Vector2d& cloth_size_m) {
  const PersonBody body(person.height_m);
  Tailor tailor(person, cloth_size_m);
  AddTrunk(person, body, tailor);
  AddHead(person, body, tailor);
  for (int side = 0; side < 2; ++side) {
    AddArm(person, body, side, tailor);
    AddLeg(person, body, side, tailor);
  }
  return std::move(tailor.surfaces);
}

}  // namespace gaitcam
