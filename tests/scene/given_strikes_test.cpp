#include "scene/detail/given_strikes.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::scene {
namespace {

class GivenStrikes : public testing::Test {
 protected:
  std::vector<GivenStrike> read(const std::string& text) {
    std::ofstream(path_) << text;
    return read_given_strikes(path_);
  }
  std::string refusal(const std::string& text) {
    try {
      read(text);
    } catch (const core::InputError& error) {
      return error.what();
    }
    return "accepted";
  }

 private:
  const core::TemporaryFolder folder_;
  const std::string path_ = folder_ / "strikes.csv";
};

TEST_F(GivenStrikes, ForcesBecomeImpulses) {
  const auto strikes = read(
      "# hammer\nshape,x_m,y_m,z_m,dx,dy,dz,peak_force_n,contact_time_s\n"
      "cup-000, 0.01, 0.02, 0.03, 0, 0, -2, 100, 0.0004\r\n*,0,0,0,,,,50,0.001\n");
  ASSERT_EQ(strikes.size(), 2u);
  EXPECT_EQ(strikes[0].shape, "cup-000");
  EXPECT_DOUBLE_EQ(strikes[0].impulse, 0.02);
  EXPECT_EQ(strikes[0].direction, Vec3(0, 0, -1));
  EXPECT_FALSE(strikes[1].direction.has_value());
  EXPECT_DOUBLE_EQ(strikes[1].impulse, 0.025);
}

TEST_F(GivenStrikes, MistakesNameTheLine) {
  const std::string header = "x_m,y_m,z_m,impulse_ns,contact_time_s\n";
  EXPECT_NE(refusal(header + "0,0,zero,1,0.001\n").find(":2: z_m"), std::string::npos);
  EXPECT_NE(refusal(header + "0,0,0,1\n").find("contact_time_s"), std::string::npos);
  EXPECT_NE(refusal(header + "0,0,0,-1,0.001\n").find("not positive"), std::string::npos);
  EXPECT_NE(refusal(header + "0,0,0,1,0.001,9\n").find("more cells"), std::string::npos);
  EXPECT_NE(refusal("x_m,y_m,z,impulse_ns,contact_time_s\n0,0,0,1,1\n").find("unknown column"),
            std::string::npos);
  EXPECT_NE(refusal(header).find("no strikes"), std::string::npos);
  EXPECT_NE(refusal("").find("no strikes"), std::string::npos);
}

}  // namespace
}  // namespace carillon::scene
