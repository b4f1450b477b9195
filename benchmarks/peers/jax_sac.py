"""Updates per second of Soft Actor-Critic in JAX, written to be fast on a processor. Protocol: protocol.py.

    python benchmarks/peers/jax_sac.py --hidden 128 --threads 1

The arithmetic of crates/gaitshift-sac with its defaults: ReLU networks of two hidden layers, two critics with targets
(Polyak 0.005), a squashed Gaussian with ln sigma in [-5, 2], alpha fixed at 0.2, Adam at 3e-4, batches of 256 drawn
uniformly from 200,000 transitions that stay on the device. Many updates make one call: sampling, both gradients, Adam
and targets are compiled together and the interpreter sees none of them. One update of it agrees with PyTorch's to 2e-7.

Tried with JAX 0.10.2 on one core, all in turn, updates per second of processor time, median (least to greatest), the
machine not quiet; what stands here is among the fastest, and hardly anything differs by more than the noise:

| | 64 units | 128 units | 256 units |
| --- | --- | --- | --- |
| optax.flatten, one vector of parameters (here) | 932 (895 to 1064) | 327 (299 to 333) | 99 (92 to 103) |
| Adam written out for each tensor | 792 (717 to 869) | 329 (305 to 366) | 91 (88 to 97) |
| the same, 1000 updates a call instead of 100 | 901 (837 to 937) | 329 (311 to 336) | 92 (92 to 105) |
| the same, critics stacked by vmap | 911 (849 to 1013) | 311 (291 to 321) | 94 (91 to 95) |
| the same, critics sharing one wide first layer | 945 (869 to 1018) | – | 93 (87 to 101) |
| the same, units in rows, batch in columns | 869 (788 to 939) | – | 94 (88 to 96) |
| the same, --xla_cpu_enable_fast_math | 921 (725 to 1099) | 337 (308 to 364) | 95 (89 to 107) |
| the same, oneDNN | – | 326 (305 to 370) | – |
| the same, XNNPACK | – | 323 (298 to 344) | – |
| the same, YNNPACK for single products | – | 328 (302 to 340) | – |
| the same, all batches gathered before the scan | – | 328 (315 to 346) | – |
| the same, scan unrolled 4 times | – | 314 (305 to 372) | – |
| the same, one array for each column of the replay | – | 317 (285 to 356) | – |
| the same, generator unsafe_rbg | – | 318 (311 to 329) | – |
| the same, random numbers drawn within the scan | – | 310 (298 to 368) | – |
| optax without flatten | – | 321 (312 to 389) | – |
"""

import argparse
import math
from functools import partial

from protocol import limit_threads, serve

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--hidden", type=int, default=128, help="units of each of the two hidden layers")
parser.add_argument("--threads", type=int, default=1)
parser.add_argument("--updates-per-call", type=int, default=100, metavar="N", help="length of the scan [default: 100]")
parser.add_argument("--stacked", action="store_true", help="both critics as one, by vmap [default: each for itself]")
arguments = parser.parse_args()
limit_threads(arguments.threads)

import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402
import optax  # noqa: E402

jax.config.update("jax_platforms", "cpu")

OBSERVATIONS, ACTIONS, TRANSITIONS, BATCH = 14, 2, 200_000, 256
LEARNING_RATE, TAU, ALPHA, GAMMA = 3e-4, 0.005, 0.2, 0.99
UPDATES_PER_CALL = arguments.updates_per_call
# Columns of a transition: observation, action, reward, discount (0 after a fall), next observation.
REWARD = OBSERVATIONS + ACTIONS
DISCOUNT, NEXT = REWARD + 1, REWARD + 2


def network(key, inputs, outputs):
    """Weights and biases, initialised as PyTorch's `nn.Linear`."""
    sizes, layers = [inputs, arguments.hidden, arguments.hidden, outputs], []
    for layer_key, rows, columns in zip(jax.random.split(key, 3), sizes, sizes[1:]):
        keys, bound = jax.random.split(layer_key), rows**-0.5
        layers.append(tuple(
            jax.random.uniform(one, shape, minval=-bound, maxval=bound)
            for one, shape in zip(keys, [(rows, columns), (columns,)])
        ))
    return layers


def forward(layers, x):
    for weight, bias in layers[:-1]:
        x = jax.nn.relu(x @ weight + bias)
    weight, bias = layers[-1]
    return x @ weight + bias


def policy(actor, observation, noise):
    """Actions and their log-probabilities."""
    out = forward(actor, observation)
    mean, log_deviation = out[:, :ACTIONS], jnp.clip(out[:, ACTIONS:], -5.0, 2.0)
    u = mean + jnp.exp(log_deviation) * noise
    log_slope = 2 * (math.log(2) - u - jax.nn.softplus(-2 * u))
    log_prob = -0.5 * noise**2 - log_deviation - 0.5 * math.log(2 * math.pi) - log_slope
    return jnp.tanh(u), log_prob.sum(axis=1)


def values(critics, observation, action):
    pair = jnp.concatenate([observation, action], axis=1)
    if arguments.stacked:
        return jax.vmap(forward, (0, None))(critics, pair)[:, :, 0]
    return [forward(critic, pair)[:, 0] for critic in critics]


# All parameters in one vector: one pass instead of one for each weight and bias.
adam = optax.flatten(optax.adam(LEARNING_RATE))


def descend(parameters, state, gradient):
    change, state = adam.update(gradient, state, parameters)
    return optax.apply_updates(parameters, change), state


def update(replay, learner, drawn):
    actor, critics, targets, actor_adam, critic_adam = learner
    rows, noise, next_noise = drawn
    batch = replay[rows]
    observation, action, following = batch[:, :OBSERVATIONS], batch[:, OBSERVATIONS:REWARD], batch[:, NEXT:]

    next_action, next_log_prob = policy(actor, following, next_noise)
    value = jnp.minimum(*values(targets, following, next_action)) - ALPHA * next_log_prob
    target = batch[:, REWARD] + batch[:, DISCOUNT] * value

    def critic_loss(critics):
        return sum(0.5 * jnp.mean((q - target) ** 2) for q in values(critics, observation, action))

    critics, critic_adam = descend(critics, critic_adam, jax.grad(critic_loss)(critics))
    targets = jax.tree.map(lambda slow, fast: slow + TAU * (fast - slow), targets, critics)

    def actor_loss(actor):
        action, log_prob = policy(actor, observation, noise)
        return jnp.mean(ALPHA * log_prob - jnp.minimum(*values(critics, observation, action)))

    actor, actor_adam = descend(actor, actor_adam, jax.grad(actor_loss)(actor))
    return (actor, critics, targets, actor_adam, critic_adam), None


@partial(jax.jit, donate_argnums=(0, 1))
def many_updates(learner, key, replay):
    key, rows_key, noise_key = jax.random.split(key, 3)
    rows = jax.random.randint(rows_key, (UPDATES_PER_CALL, BATCH), 0, TRANSITIONS)
    noise = jax.random.normal(noise_key, (2, UPDATES_PER_CALL, BATCH, ACTIONS))
    learner, _ = jax.lax.scan(partial(update, replay), learner, (rows, *noise))
    return learner, key


def random_replay(key):
    """Transitions without meaning but with plausible magnitudes, one in each row."""
    keys = jax.random.split(key, 5)
    return jnp.concatenate([
        jax.random.normal(keys[0], (TRANSITIONS, OBSERVATIONS)),
        jax.random.uniform(keys[1], (TRANSITIONS, ACTIONS), minval=-1.0),
        jax.random.normal(keys[2], (TRANSITIONS, 1)),
        GAMMA * (jax.random.uniform(keys[3], (TRANSITIONS, 1)) > 0.002),
        jax.random.normal(keys[4], (TRANSITIONS, OBSERVATIONS)),
    ], axis=1)


key, *keys = jax.random.split(jax.random.key(1), 5)
replay = random_replay(keys[0])
actor = network(keys[1], OBSERVATIONS, 2 * ACTIONS)
critics = [network(one, OBSERVATIONS + ACTIONS, 1) for one in keys[2:]]
if arguments.stacked:
    critics = jax.tree.map(lambda *pair: jnp.stack(pair), *critics)
targets = jax.tree.map(jnp.copy, critics)
learner = (actor, critics, targets, adam.init(actor), adam.init(critics))


def work():
    global learner, key
    learner, key = many_updates(learner, key, replay)
    jax.block_until_ready(learner)
    return UPDATES_PER_CALL


serve(work)
