"""One file per engine; the file is the engine.  This page is the contract, for our files and for a user's own.

An engine file has at module level

    METHODS   the names of its integrators, first the one that is taken where one is enough
    FEATURES  the force laws it can express exactly, of: gravity, tether, drag, floor, plane
    ABOUT     a dict: version, precision ("single" or "double"), switched_off (a list of what was switched off to be
              fair) and, where it has any, defaults (a list of what a user gets who sets nothing)

and four verbs on whole states (N, 13): x [m], q (w x y z, body to world), v [m/s], w [rad/s], all in world axes

    build(scene, method) -> world    untimed; switches off all that the scene has not got;
                                     NotImplementedError(why) where the engine cannot do this scene
    write(world, states)             the states into the world; forgets all history
    advance(world, n, dt)            n steps of dt [s] in the engine's native loop: the only timed call
    read(world) -> states            (N, 13)

`tumble engines --check ./mine.py` runs the CHECKS below on a file, and the CONTACT_CHECKS where it has a plane
(compare/run/engines/contract_checks.py).

More names where they are not empty:

    ADAPTIVE    {method: tolerance} of methods that choose their own steps: METHOD alone takes that tolerance,
                METHOD@TOLERANCE another; plain names where none is to be told
    WHOLE       methods that take a flight of any length in one step
    FORCED      names, not in METHODS, that take part only in scenes with a tether, drag or a floor: without one they
                are the method they are named after.  METHOD+held is told the force once a step and holds it, which is
                what scripts do; METHOD evaluates it wherever the method does, or says that it cannot
    CONTACT     names, not in METHODS, that take part only in scenes with a plane; METHOD+VARIANT is METHOD without one
    ON_REQUEST  names, not in METHODS, that take part only when asked for.  METHOD+defaults leaves every setting of the
                engine as it ships, which is what its users have; its audit tells what those do to a flight
    DEFAULT     of METHODS and ON_REQUEST those that do what the engine does where its user sets nothing, and that alone
                are called its default; without it METHOD+defaults where there is one, else the first of METHODS
    SHOWN       of METHODS and ON_REQUEST those that a page is made of unless more are asked for: the first, the default
                where that differs, and its best; without it all METHODS
    LANDING     the same above a plane, of METHODS and CONTACT: each contact law once; without it those of SHOWN
    OPTIONAL    what build leaves out where a scene has no use for it.  build(scene, method, keep) then takes the
                names of those that shall stay: the motion is the same, and what they cost can be measured
    SCHEMES     {method: scheme}: what one step makes of u'' + c u' + s u = 0, for the limit of a step: a name of
                SCHEME_NAMES, or a function (stiffness s, damping c, step h) -> 2x2 matrix on (u, u')
    GYROSCOPIC  {method: how}: how it takes the torque (I w) x w of a free body, a name of GYROSCOPIC_NAMES
    ORDERS      {method: order}: by which power of the step the error of a free, tumbling body falls; 1 where GYROSCOPIC
                says that the torque is taken by a method of Euler's
    LARGEST_TURN  rad: no step turns a body further
    STEP_NS     about what a step of one throw takes [ns], to a factor of a few, or {method: that} where methods differ;
                50 000 where it is not said.  A sweep's ladder ends by it and not by a clock, and `tumble stability`
                refuses what would take too long, so that their rows are the same whatever else the machine does
    INSTANTS    the only sample instants at which the engine has an answer [s]; it takes part in scenes with others only
                when it is asked for
    REUSES_WORLD  whether a world depends on nothing of a scene's duration, samples and step, so that runs which differ
                in these alone may have one, which `write` makes forget the run before; without it each has a new world
    SENSE       how `sense` reads: "sensor", which is taken where it is not said: by the engine's own; "derivatives": by
                the equations of motion in the state; or {method: that}, where other methods have no `sense`
    EXEMPT      {law: why}: laws that the engine is there to break
    KNOWN_FAILURES  {check: {method: why}}: checks that a method fails by its own law, and no mistake of the file; * is
                every method.  They are made all the same: one that passes is stated wrongly

An engine of ours says, as literals, which are read where the engine itself is not installed:

    PACKAGES    the packages that bring it, the one to install first; their releases stand beside all numbers
    PINS        what an environment of its own gets (`tumble engines --install`), as pip reads it: first PACKAGES[0],
                with the release of it that is meant where none is asked for
    PYTHON      the release of Python that its wheels are for, where they are not for all
    INSTALLER   "apt" where the first of PINS is in Debian and on no index, and DEBIAN the packages that bring it
    APART       whether it has an environment of its own everywhere, and takes part only when asked for
    MEGABYTES   what such an environment takes

And verbs if it wishes

    prepare(world, dt)               untimed, before every `advance` of steps of dt [s], for an engine that fixes its
                                     step when built; the states stay
    audit(world) -> findings         what went wrong silently since write: pairs (kind, text), the kind of FINDINGS.
                                     A plain string is a finding of the kind `other`: it flags a run and decides no
                                     verdict
    vertices(world, points)          where body points (n, 3) of a body that is no longer rigid are: (N, n, 3);
                                     without it, or where it is None, the harness computes them from the state
    sense(world) -> readings         what the sensors of scene.sensors read in the state as it is, (N, S, 6): specific
                                     force [m/s2] and angular velocity [rad/s], each along the sensor's own axes;
                                     without it the harness takes differences of velocity over a step (docs/sensors.md)
    remark(world) -> str             what the user should know and is no fault: which method was chosen, and why
    soft_law(world) -> law           the spring and damper of its contact (`parts/soft_law.py`), None where it has none:
                                     the run is compared with that law too

An engine file imports nothing of ours that a user's own could not: it reads the attributes of the scene it is given
(`scenarios/scene.py`), except that our own solver's file imports `solver`, and that ours share `parts/`, which is a
folder, and so no engine.  Where an engine must be told the force, it is `scenarios/wrench.py`'s, so that all who hold a
force hold the same; a user would write those few lines himself.
"""

BY_HAND = "handcalc"  # the class report's hand calculation: no engine that anybody would choose
SHIPPED = "+defaults"  # the manner of a method with which its engine is left as it ships
OWN = "tumble"  # our own solver's file: the first in every list, and what flies where no engine is named
OWN_ON_PLANE = "tumble:events"  # the same in a scene with a plane, which its first method has not

CHECKS = {
    "read after write": "read(write(s)) = s to rounding, q up to its sign",
    "digits": "no digit of a number is lost on the way: 17 of a double, 9 of a single",
    "steps add up": "advance(a) then advance(b) = advance(a + b), bit by bit",
    "write forgets": "a run after write equals that of a new world, bit by bit",
    "throws are apart": "a throw moves as it would alone, bit by bit",
    "straight": "with no force and no spin x + v t, to rounding",
    "gravity": "with gravity v + g t, to rounding",
    "turns": "a spin about a principal axis goes on, and the attitude turns about it",
    "converges": "half the step, smaller error, by the order that is stated: a tumbling brick",
    "light": "a body of a millionth of the mass moves the same way, to rounding",
    "the scene": "is not altered",
    "optional": "what OPTIONAL keeps changes no motion",
    "sensors": "free fall reads 0, a spin w^2 r towards its axis, lever arms add, a held body +g upwards",
}

# Of engines with a plane; steps add up, write forgets and throws are apart there too.
CONTACT_CHECKS = {
    "friction": "a ball slows at mu g, mu the scene's whatever the rule that mixes two materials",
    "restitution": "a ball rebounds at e times its speed, e the scene's, wherever in a step it meets the plane",
    "stays above": "nothing gets below a plane by more than five steps' way",
    "adds no energy": "an impact adds no energy",
    "holds": "a box at rest below the critical angle does not creep",
    "any direction": "friction does not depend on a direction in the plane",
    "mirror images": "mirror images stay mirror images",
}

FINDINGS = {
    "reset": "the state was put back to some start",
    "frozen": "nothing moved although it should",
    "clamped": "a velocity was cut to a limit",
    "lost-torque": "a torque was left out",
    "under-rotated": "the body turned by less than its angular velocity says",
    "damped": "a setting of the engine's takes energy that physics keeps",
    "another-body": "mass or moments are not those asked for",
    "bad-number": "the engine counted numbers that are not finite or too large",
    "unsolved": "an equation of a step was not solved",
    "unstable": "the step is longer than the method is stable for",
    "deformed": "the attitude is no rotation any more",
    "tolerance": "the tolerance is not the one asked for",
    "other": "anything else",
}

SCHEME_NAMES = {
    "semi-implicit-euler": "the velocity by the force at the start of the step, then the position by the new velocity",
    "damping-implicit-euler": "the same with the damper's force at the end of the step",
    "drag-implicit-euler": "semi-implicit Euler; of dampers only drag is taken at the end of the step",
    "held-parabola": "the force at the start of the step held over it, and the motion under that exact",
    "rk4": "any Runge-Kutta method of order 4 with four stages",
    "a-stable": "bounded at every step",
}

GYROSCOPIC_NAMES = {
    "none": "not at all: the angular velocity stands still",
    "explicit": "by explicit Euler, which adds energy at every step",
    "implicit": "by implicit Euler, which takes energy at every step",
    "rescaled": "explicitly, and the angular momentum set back to its length",
    "midpoint": "by the implicit midpoint rule",
    "keeps-momentum": "so that the angular momentum is kept at every step",
}
# Those of Euler's, by the order with which an error falls.
EULER = {"explicit": 1.0, "implicit": 1.0, "rescaled": 1.0}
