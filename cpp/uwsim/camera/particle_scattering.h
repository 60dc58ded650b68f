#pragma once

namespace uwsim {

/// The share of the light that particles scatter by less than an angle, in [0, pi]: Fournier and Forand 1994 (Proc.
/// SPIE 2258:194), in Fournier and Jonasz's form of 1999 (Proc. SPIE 3761:62), for particles with a relative refractive
/// index of 1.1 whose numbers fall with the 3.5835th power of their size. They send back the 1.8 % of
/// `upwelling_share` (Mobley, Sundman and Boss 2002, Appl. Opt. 41:1035). Petzold's (1972) scatter four fifths by less
/// than 15 degrees, these 0.79.
double scattered_within(double angle_rad);

/// The share of a pattern of light at wave number k [rad/m], across the way, that light scattered once somewhere along
/// a path d keeps, by x = k d: the mean over the path of the phase function's Hankel transform, small angles (Wells
/// 1973).
double kept_when_scattered(double x);

}  // namespace uwsim
