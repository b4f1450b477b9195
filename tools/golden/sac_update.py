"""Records whole Soft Actor-Critic updates made by PyTorch, as golden values for the Rust learner.

    python -m venv .venv && .venv/bin/pip install -r tools/golden/requirements.txt
    .venv/bin/python tools/golden/sac_update.py crates/gaitshift-sac/tests/golden

Everything PyTorch offers is taken from PyTorch: layers, layer normalisation, the tanh-transformed normal
distribution, automatic differentiation, Adam. Written in float64, so that the Rust code run
in f64 must agree to rounding.
"""

import json
import sys
from pathlib import Path

import torch
from safetensors.torch import save_file
from torch import nn
from torch.distributions import Normal, TransformedDistribution
from torch.distributions.transforms import TanhTransform
from torch.nn import functional

OBSERVATIONS, ACTIONS, ROWS, UPDATES = 5, 2, 70, 3
LOG_DEVIATION = (-5.0, 2.0)
CASES = {
    "plain": dict(
        actor_hidden=[12, 10], critic_hidden=[12, 10], critic_layer_norm=False,
        learning_rate=1e-3, tau=0.005, temperature=dict(kind="fixed", alpha=0.2),
    ),
    "all_options": dict(
        actor_hidden=[10, 9], critic_hidden=[11, 12, 8], critic_layer_norm=True,
        learning_rate=3e-3, tau=0.02,
        temperature=dict(kind="auto", initial=0.4, target_entropy=-2.0, learning_rate=5e-3),
    ),
}


class Network(nn.Module):
    """[linear, layer norm?, ReLU] per hidden layer, then linear; parameters named as the Rust code names them."""

    def __init__(self, inputs, hidden, outputs, layer_norm):
        super().__init__()
        self.layers = nn.ModuleList()
        for units in hidden:
            layer = nn.Linear(inputs, units)
            if layer_norm:
                layer.norm = nn.LayerNorm(units)
                nn.init.uniform_(layer.norm.weight, 0.5, 1.5)
                nn.init.uniform_(layer.norm.bias, -0.5, 0.5)
            self.layers.append(layer)
            inputs = units
        self.output = nn.Linear(inputs, outputs)

    def forward(self, x):
        for layer in self.layers:
            x = functional.linear(x, layer.weight, layer.bias)
            if hasattr(layer, "norm"):
                x = layer.norm(x)
            x = functional.relu(x)
        return self.output(x)


def sample(actor, observations, noise):
    """Actions and log-probabilities; the transform remembers u, so that atanh(tanh(u)) loses nothing."""
    mean, log_deviation = actor(observations).chunk(2, dim=-1)
    deviation = log_deviation.clamp(*LOG_DEVIATION).exp()
    transform = TanhTransform(cache_size=1)
    distribution = TransformedDistribution(Normal(mean, deviation), transform)
    actions = transform(mean + deviation * noise)
    return actions, distribution.log_prob(actions).sum(-1)


def record(case, settings):
    torch.manual_seed(20240229)
    tensors = {}

    def keep(name, value):
        tensors[name] = value.detach().clone().contiguous()

    def keep_network(prefix, network):
        for name, parameter in network.named_parameters():
            keep(f"{prefix}.{name}", parameter)

    def keep_gradient(prefix, network):
        for name, parameter in network.named_parameters():
            keep(f"{prefix}.{name}", parameter.grad)

    actor = Network(OBSERVATIONS, settings["actor_hidden"], 2 * ACTIONS, layer_norm=False)
    critics, targets = (
        [
            Network(OBSERVATIONS + ACTIONS, settings["critic_hidden"], 1, settings["critic_layer_norm"])
            for _ in range(2)
        ]
        for _ in range(2)
    )
    for prefix, network in [
        ("actor", actor), ("critic_1", critics[0]), ("critic_2", critics[1]),
        ("target_1", targets[0]), ("target_2", targets[1]),
    ]:
        keep_network(f"start.{prefix}", network)

    rate = settings["learning_rate"]
    actor_adam = torch.optim.Adam(actor.parameters(), lr=rate)
    critic_adam = torch.optim.Adam([p for critic in critics for p in critic.parameters()], lr=rate)
    temperature = settings["temperature"]
    automatic = temperature["kind"] == "auto"
    log_alpha = torch.tensor(temperature["initial"] if automatic else temperature["alpha"]).log().requires_grad_()
    alpha_adam = torch.optim.Adam([log_alpha], lr=temperature.get("learning_rate", 1.0))

    for update in range(1, UPDATES + 1):
        at = f"update_{update}"
        observations = torch.randn(ROWS, OBSERVATIONS)
        next_observations = torch.randn(ROWS, OBSERVATIONS)
        actions = torch.rand(ROWS, ACTIONS) * 2 - 1
        rewards = torch.randn(ROWS)
        discounts = torch.where(torch.rand(ROWS) < 0.2, 0.0, 0.99)
        noise_next = torch.randn(ROWS, ACTIONS)
        noise = torch.randn(ROWS, ACTIONS)
        for name, value in dict(
            observations=observations, next_observations=next_observations, actions=actions, rewards=rewards,
            discounts=discounts, noise_next=noise_next, noise_current=noise,
        ).items():
            keep(f"{at}.{name}", value)
        alpha = log_alpha.detach().exp()

        with torch.no_grad():
            next_actions, next_log_probs = sample(actor, next_observations, noise_next)
            next_input = torch.cat([next_observations, next_actions], -1)
            value = torch.min(targets[0](next_input), targets[1](next_input)).squeeze(-1)
            y = rewards + discounts * (value - alpha * next_log_probs)
        inputs = torch.cat([observations, actions], -1)
        losses = [0.5 * functional.mse_loss(critic(inputs).squeeze(-1), y) for critic in critics]
        critic_adam.zero_grad()
        sum(losses).backward()
        for number, critic in enumerate(critics, 1):
            keep_gradient(f"{at}.gradient.critic_{number}", critic)
        critic_adam.step()
        keep(f"{at}.critic_loss", torch.stack(losses))

        new_actions, log_probs = sample(actor, observations, noise)
        new_input = torch.cat([observations, new_actions], -1)
        smaller = torch.min(critics[0](new_input), critics[1](new_input)).squeeze(-1)
        actor_loss = (alpha * log_probs - smaller).mean()
        actor_adam.zero_grad()
        actor_loss.backward()
        keep_gradient(f"{at}.gradient.actor", actor)
        actor_adam.step()
        keep(f"{at}.actor_loss", actor_loss)
        keep(f"{at}.entropy", -log_probs.mean())
        if automatic:
            alpha_loss = -(log_alpha * (log_probs.detach() + temperature["target_entropy"])).mean()
            alpha_adam.zero_grad()
            alpha_loss.backward()
            alpha_adam.step()
        keep(f"{at}.log_alpha", log_alpha)

        with torch.no_grad():
            for critic, target in zip(critics, targets):
                for kept, new in zip(target.parameters(), critic.parameters()):
                    kept.mul_(1 - settings["tau"]).add_(new, alpha=settings["tau"])
        for prefix, network in [
            ("actor", actor), ("critic_1", critics[0]), ("critic_2", critics[1]),
            ("target_1", targets[0]), ("target_2", targets[1]),
        ]:
            keep_network(f"{at}.after.{prefix}", network)

    config = {**settings, "batch_size": ROWS}
    header = dict(
        torch=torch.__version__, observations=OBSERVATIONS, actions=ACTIONS, updates=UPDATES, config=config,
    )
    return tensors, {"golden": json.dumps(header)}


def main():
    torch.set_default_dtype(torch.float64)
    torch.use_deterministic_algorithms(True)
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for case, settings in CASES.items():
        tensors, metadata = record(case, settings)
        path = folder / f"{case}.safetensors"
        save_file(tensors, path, metadata)
        path.chmod(0o644)
        print(case, len(tensors), "tensors")


if __name__ == "__main__":
    main()
