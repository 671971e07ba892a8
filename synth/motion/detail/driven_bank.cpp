#include "synth/motion/detail/driven_bank.hpp"

#include <array>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "synth/motion/detail/driven_bank.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace carillon::synth::motion::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Lanes = hn::CappedTag<double, bank_lanes>;
using Vector = hn::Vec<Lanes>;

/// One vector of modes under its forces; what it is goes to the buffers.
template <bool forced>
HWY_INLINE void run_vector(DrivenBank& bank, std::size_t first, const double* forces,
                           std::size_t count, double* q_out, double* v_out) {
  const Lanes lanes;
  const std::size_t width = hn::Lanes(lanes);
  const auto load = [&](std::size_t part)
                        HWY_ATTR { return hn::LoadU(lanes, bank.steps[part].data() + first); };
  const Vector qq = load(0), qv = load(1), vq = load(4), vv = load(5);
  Vector q = hn::LoadU(lanes, bank.q.data() + first);
  Vector v = hn::LoadU(lanes, bank.v.data() + first);
  if constexpr (forced) {
    const Vector qb = load(2), qe = load(3), vb = load(6), ve = load(7);
    Vector begin = hn::LoadU(lanes, forces);
    for (std::size_t t = 0; t < count; ++t) {
      hn::StoreU(q, lanes, q_out + t * width);
      hn::StoreU(v, lanes, v_out + t * width);
      const Vector end = hn::LoadU(lanes, forces + (t + 1) * width);
      const Vector of_q = hn::MulAdd(qe, end, hn::Mul(qb, begin));
      const Vector of_v = hn::MulAdd(ve, end, hn::Mul(vb, begin));
      const Vector next = hn::MulAdd(qq, q, hn::MulAdd(qv, v, of_q));
      v = hn::MulAdd(vq, q, hn::MulAdd(vv, v, of_v));
      q = next;
      begin = end;
    }
  } else {
    for (std::size_t t = 0; t < count; ++t) {
      hn::StoreU(q, lanes, q_out + t * width);
      hn::StoreU(v, lanes, v_out + t * width);
      const Vector next = hn::MulAdd(qq, q, hn::Mul(qv, v));
      v = hn::MulAdd(vq, q, hn::Mul(vv, v));
      q = next;
    }
  }
  hn::StoreU(q, lanes, bank.q.data() + first);
  hn::StoreU(v, lanes, bank.v.data() + first);
}

void run_bank(DrivenBank& bank, std::size_t modes, const DrivenForces& forces,
              std::span<const BankOutput> outputs, std::size_t count) {
  const Lanes lanes;
  const std::size_t width = hn::Lanes(lanes);
  alignas(64) std::array<double, (bank_stretch + 1) * bank_lanes> force;
  alignas(64) std::array<double, bank_stretch * bank_lanes> q, v;
  // Sums of each output by lane, so that lanes meet once only.
  std::vector<double> sums(outputs.size() * count * width, 0.0);
  for (std::size_t first = 0; first < modes; first += width) {
    if (forces.shapes.empty()) {
      run_vector<false>(bank, first, nullptr, count, q.data(), v.data());
    } else {
      for (std::size_t t = 0; t <= count; ++t) {
        Vector sum = hn::Zero(lanes);
        for (std::size_t part = 0; part < forces.shapes.size(); ++part) {
          sum = hn::MulAdd(hn::LoadU(lanes, forces.shapes[part] + first),
                           hn::Set(lanes, forces.courses[part][t]), sum);
        }
        hn::StoreU(sum, lanes, force.data() + t * width);
      }
      run_vector<true>(bank, first, force.data(), count, q.data(), v.data());
    }
    for (std::size_t o = 0; o < outputs.size(); ++o) {
      const Vector of_q = hn::LoadU(lanes, outputs[o].of_q + first);
      const Vector of_v = hn::LoadU(lanes, outputs[o].of_v + first);
      double* sum = sums.data() + o * count * width;
      for (std::size_t i = 0; i < count * width; i += width) {
        const Vector more = hn::MulAdd(of_q, hn::LoadU(lanes, q.data() + i),
                                       hn::Mul(of_v, hn::LoadU(lanes, v.data() + i)));
        hn::StoreU(hn::Add(hn::LoadU(lanes, sum + i), more), lanes, sum + i);
      }
    }
  }
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    for (std::size_t t = 0; t < count; ++t) {
      const double* parts = sums.data() + (o * count + t) * width;
      outputs[o].samples[t] += hn::GetLane(hn::SumOfLanes(lanes, hn::LoadU(lanes, parts)));
    }
  }
}

}  // namespace carillon::synth::motion::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carillon::synth::motion {

HWY_EXPORT(run_bank);

DrivenBank::DrivenBank(std::size_t count) : modes(count) {
  const std::size_t filled = (count + bank_lanes - 1) / bank_lanes * bank_lanes;
  q.assign(filled, 0.0);
  v.assign(filled, 0.0);
  for (std::vector<double>& part : steps) part.assign(filled, 0.0);
}

void DrivenBank::set_step(std::size_t mode, const modal::LinearForceStep& step) {
  const double parts[8] = {step.qq, step.qv, step.q_begin, step.q_end,
                           step.vq, step.vv, step.v_begin, step.v_end};
  for (std::size_t part = 0; part < 8; ++part) steps[part][mode] = parts[part];
}

void run_bank(DrivenBank& bank, std::size_t modes, const DrivenForces& forces,
              std::span<const BankOutput> outputs, std::size_t count) {
  HWY_DYNAMIC_DISPATCH(run_bank)(bank, modes, forces, outputs, count);
}

}  // namespace carillon::synth::motion
#endif  // HWY_ONCE
