// How each kind of procedural shape is made: proportions drawn first, then a mesh with edges of about `edge`.
#pragma once

#include "tests/support/irregular.h"

namespace burnish::testing {

Shape chamfered_box(double edge, Random& random);
Shape stairs(double edge, Random& random);
Shape star_prism(double edge, Random& random);
Shape bracket(double edge, Random& random);  ///< an angle with a hole
Shape block(double edge, Random& random);    ///< with a round hole
Shape cylinder(double edge, Random& random);
Shape cone(double edge, Random& random);
Shape shaft(double edge, Random& random);  ///< stepped, some shoulders rounded
Shape gear(double edge, Random& random);
Shape gem(double edge, Random& random);  ///< between random planes

Shape coarse_bumps(double edge, Random& random);  ///< on a sphere
Shape fine_bumps(double edge, Random& random);
Shape knot(double edge, Random& random);
Shape blobs(double edge, Random& random);
Shape ridges(double edge, Random& random);  ///< open, as the next two
Shape cloth(double edge, Random& random);
Shape hair(double edge, Random& random);

Shape relief(double edge, Random& random);  ///< a block whose top is a landscape
Shape vase(double edge, Random& random);
Shape twisted_star(double edge, Random& random);

}  // namespace burnish::testing
