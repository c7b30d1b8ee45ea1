"""An elastic follower behind its cam: response, jump, residual vibration, polydyne lift."""
