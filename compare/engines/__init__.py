"""One file per engine; the file is the engine.

An engine file, ours or a user's, has at module level

    METHODS   the names of its integrators, the default first
    FEATURES  the force laws it can express exactly, of: gravity, tether, drag, floor
    ABOUT     a dict: version, precision, switched_off (a list of what was switched off to be fair)

and four verbs on whole states (N, 13) of design.md, section 3:

    build(scene, method) -> world    untimed; switches off all that the scene has not got;
                                     NotImplementedError(why) where the engine cannot do this scene
    write(world, states)             the states into the world; forgets all history
    advance(world, n, dt)            n steps of dt in the engine's native loop: the only timed call
    read(world) -> states            (N, 13)

More lists where they are not empty:

    ADAPTIVE    methods that choose their own steps, named METHOD@TOLERANCE; METHOD alone takes its own default
    WHOLE       methods that take a flight of any length in one step
    FORCED      names, not in METHODS, that take part only in scenes with a tether, drag or a floor: without one they
                are the method they are named after.  METHOD+held is told the force once a step and holds it, which is
                what scripts do; METHOD evaluates it wherever the method does, or says that it cannot
    ON_REQUEST  names, not in METHODS, that take part only when asked for.  METHOD+defaults leaves every setting of the
                engine as it ships, which is what its users have; its audit tells what those do to a flight
    OPTIONAL    what build leaves out where a scene has no use for it.  build(scene, method, keep) then takes the
                names of those that shall stay: the motion is the same, and what they cost can be measured

And three more verbs if it wishes

    audit(world) -> list[str]        what went wrong silently since write
    vertices(world, points)          where body points (n, 3) of a body that is no longer rigid are: (N, n, 3);
                                     without it the harness computes them from the state
    remark(world) -> str             what the user should know and is no fault: which method was chosen, and why

An engine file imports nothing of ours that a user's own could not: it reads the attributes of the scene it is given
(`scenarios/scene.py`), except that our own solver's file imports `solver`.  Where an engine must be told the force, it
is `scenarios/wrench.py`'s, so that all who hold a force hold the same; a user would write those few lines himself.
"""
